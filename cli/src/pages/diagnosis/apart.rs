//! What tells causes apart that look alike, where it is not a command that does it.

/// Two kinds, and what to do.
type Pair = (&'static str, &'static str, &'static str);

const PAIRS: &[Pair] = &[
    (
        "asymmetric-friction",
        "constant-load",
        "both hold and drag with the same force in either direction, so that no command tells them apart: incline the axis, or take cables and \
         counterweights off, and record again; a load changes with them, friction does not",
    ),
    (
        "actuator-lag",
        "command-delay",
        "excite the drive at higher frequencies: a lag takes the amplitude down there, a delay does not",
    ),
    (
        "force-delay",
        "force-lag",
        "tap the tool with the drive off and record force and acceleration: a lag rounds the blow, a delay only shifts it",
    ),
    (
        "coulomb-friction",
        "stribeck-friction",
        "move at steady speeds from creeping up: only one of them rises again towards standstill",
    ),
    (
        "coulomb-friction",
        "load-friction",
        "repeat the strokes with another payload or clamping force: only one of them grows with it",
    ),
    (
        "coulomb-friction",
        "drive-deadband",
        "push the axis by hand or with a spring scale: friction stays, a dead band of the drive does not",
    ),
    (
        "added-mass",
        "drive-gain",
        "weigh what moves, or read the drive's force with a spring scale against a stop",
    ),
    ("contact-stiffness", "force-gain", "hang a known weight on the force sensor"),
    (
        "hertz-contact",
        "surface-offset",
        "press at several levels of force: one of them grows stiffer with force",
    ),
    ("hardening-stiffness", "hertz-contact", "press at several levels of force, down to the smallest"),
    ("backlash", "surface-offset", "reverse the force while the tool stays in contact: only free play shows"),
];

/// What tells two kinds apart, in words; none where nothing is known.
pub(super) fn apart(a: &str, b: &str) -> Option<&'static str> {
    let is_of = |pair: &&Pair| (pair.0 == a && pair.1 == b) || (pair.0 == b && pair.1 == a);
    PAIRS.iter().find(is_of).map(|pair| pair.2)
}

#[cfg(test)]
mod tests {
    use feeler_plant::effects::LIBRARY;

    use super::*;

    #[test]
    fn truth_pairs_are_of_the_library_and_found_either_way_round() {
        for (a, b, what) in PAIRS {
            for kind in [a, b] {
                assert!(LIBRARY.iter().any(|definition| definition.kind == *kind), "{kind}");
            }
            assert_eq!(apart(a, b), Some(*what));
            assert_eq!(apart(b, a), Some(*what));
        }
        assert_eq!(apart("backlash", "added-mass"), None);
    }
}
