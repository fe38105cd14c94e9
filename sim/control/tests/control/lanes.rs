//! A variant gives the same bits in any lane of any width.

use feeler_control::{
    AdmittanceGains, AntiWindup, Approach, Controller, ControllerSpec, ForceGains, ImpedanceGains, Inputs,
    Law, LeadSpec, LowPassSpec, NotchSpec, PositionGains, Stream,
};
use feeler_lanes::{Lane, LaneMask, Pack};

const VARIANTS: usize = 8;
const SAMPLES: u64 = 300;

/// Variant `i` of a law. The gains differ, and some variants have a lead, a filter, an approach, a limit or a
/// resolution where others have none.
fn variant(law: usize, i: usize) -> ControllerSpec {
    let x = i as f64;
    let anti_windup = match i % 3 {
        0 => AntiWindup::Conditional,
        1 => AntiWindup::BackCalculation { tracking_time_s: 0.01 + 0.01 * x },
        _ => AntiWindup::Off,
    };
    let law = match law {
        0 => Law::OpenLoop,
        1 => Law::ExplicitForce(ForceGains {
            feed_forward: 0.1 * x,
            kp: 0.5 + 0.3 * x,
            ki: 20.0 - x,
            kd: 1e-3 * x,
            damping: 5.0 * x,
            derivative_filter_s: 1e-3 * x,
            lead: i.is_multiple_of(2).then_some(LeadSpec { zero_hz: 20.0 + x, pole_hz: 150.0 }),
            anti_windup,
        }),
        2 => Law::Position(PositionGains {
            kp: 900.0 + x,
            ki: 40.0 * x,
            kd: 3.0,
            damping: 7.0 * x,
            derivative_filter_s: 2e-3,
            anti_windup,
        }),
        3 => {
            Law::Impedance(ImpedanceGains { stiffness: 800.0 + 90.0 * x, damping: 11.0, force_gain: 0.2 * x })
        }
        _ => Law::Admittance(AdmittanceGains {
            mass: 0.5 * x,
            damping: 8.0 + x,
            stiffness: 30.0 * x,
            kp: 400.0,
            kd: 2.0 * x,
            velocity_feed_forward: 0.5,
        }),
    };
    let approach = (i % 4 != 3 && !matches!(law, Law::Position(_))).then(|| Approach {
        release: i.is_multiple_of(2).then_some(-0.5),
        velocity_drive: i == 5,
        ..Approach::new(0.03, 0.5 + 0.1 * x, 3.0 + x)
    });
    ControllerSpec {
        approach,
        output_limit: (i % 3 != 2).then_some(6.0 + x),
        output_resolution: (i % 2 == 1).then_some(0.01 * x),
        reading_low_pass: (i > 4)
            .then_some(LowPassSpec { cutoff_hz: 80.0, damping_ratio: (i == 6).then_some(0.6) }),
        reading_notch: (i % 3 == 1).then_some(NotchSpec {
            frequency_hz: 40.0 + x,
            damping_ratio: 0.3,
            depth: 0.2,
        }),
        velocity_filter_s: 1e-3 * (x - 1.0).max(0.0),
        ..ControllerSpec::new(law, 1e-3)
    }
}

/// Signals of variant `i`: reading, motion, reference.
fn signals(stream: &Stream, i: usize, k: u64) -> [f64; 3] {
    let draw = |column: u64| stream.normal_at((k * VARIANTS as u64 + i as u64) * 3 + column);
    [2.0 * draw(0), 0.01 * draw(1), 3.0 * draw(2)]
}

/// Outputs and flags of the variants `first..first + L::WIDTH`, as bits, by variant.
fn run<L: Lane>(law: usize, first: usize, motion_is_velocity: bool) -> Vec<Vec<(u64, bool, bool)>> {
    let specs: Vec<_> = (0..L::WIDTH).map(|i| variant(law, first + i)).collect();
    let mut controller = Controller::<L>::new(&specs).expect("the variants are sound");
    let stream = Stream::new(7, "lanes");
    let mut outputs = vec![Vec::new(); L::WIDTH];
    for k in 0..SAMPLES {
        let column = |c: usize| L::from_fn(|i| signals(&stream, first + i, k)[c]);
        let inputs = Inputs { reading: column(0), motion: column(1), motion_is_velocity };
        let u = controller.sample(k as f64 * 1e-3, &inputs, column(2));
        for (i, of_variant) in outputs.iter_mut().enumerate() {
            of_variant.push((
                u.lane(i).to_bits(),
                controller.in_contact_phase().test(i),
                controller.saturated().test(i),
            ));
        }
    }
    outputs
}

#[test]
fn prop_every_law_gives_the_same_bits_in_any_lane() {
    for law in 0..5 {
        for motion_is_velocity in [false, true] {
            let alone: Vec<_> = (0..VARIANTS).flat_map(|i| run::<f64>(law, i, motion_is_velocity)).collect();
            let by_four: Vec<_> =
                [0, 4].into_iter().flat_map(|first| run::<Pack<4>>(law, first, motion_is_velocity)).collect();
            assert_eq!(alone, by_four, "law {law}");
            assert_eq!(alone, run::<Pack<8>>(law, 0, motion_is_velocity), "law {law}");
            let differ = (1..VARIANTS).filter(|&i| alone[i] != alone[0]).count();
            assert_eq!(
                differ,
                VARIANTS - 1,
                "law {law}: the variants must exercise different branches for the comparison to mean anything"
            );
        }
    }
}

#[test]
fn prop_a_reset_controller_starts_again() {
    let specs: Vec<_> = (0..4).map(|i| variant(1, i)).collect();
    let mut controller = Controller::<Pack<4>>::new(&specs).unwrap();
    let stream = Stream::new(3, "reset");
    let mut run = || -> Vec<_> {
        controller.reset();
        (0..50)
            .map(|k| {
                let column = |c: usize| Pack::from_fn(|i| signals(&stream, i, k)[c]);
                let inputs = Inputs { reading: column(0), motion: column(1), motion_is_velocity: false };
                controller.sample(k as f64 * 1e-3, &inputs, column(2)).0.map(f64::to_bits)
            })
            .collect()
    };
    assert_eq!(run(), run());
}
