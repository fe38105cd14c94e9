//! Stiffness of a contact between round bodies.

/// An elastic material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    pub youngs_modulus_pa: f64,
    pub poisson_ratio: f64,
}

/// `k` in `F = k d^1.5` for two balls (Johnson, "Contact Mechanics", 1985, eq. 4.23): `4/3 E* sqrt(R)`,
/// `1/R = 1/R1 + 1/R2`, `1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2`. In N/m^1.5. A flat has an infinite radius,
/// a hollow a negative one.
pub fn hertz_stiffness(tip: (f64, Material), workpiece: (f64, Material)) -> f64 {
    let compliance = |m: Material| (1.0 - m.poisson_ratio * m.poisson_ratio) / m.youngs_modulus_pa;
    let modulus = 1.0 / (compliance(tip.1) + compliance(workpiece.1));
    let radius = 1.0 / (1.0 / tip.0 + 1.0 / workpiece.0);
    4.0 / 3.0 * modulus * radius.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_a_steel_ball_on_a_steel_flat() {
        let steel = Material { youngs_modulus_pa: 210e9, poisson_ratio: 0.3 };
        // E* = 210e9 / (2 * 0.91) = 115.385 GPa, R = 5 mm: k = 4/3 * 115.385e9 * sqrt(0.005).
        let k = hertz_stiffness((5e-3, steel), (f64::INFINITY, steel));
        assert!((k / 1.087_858e10 - 1.0).abs() < 1e-5, "{k:e}");
    }
}
