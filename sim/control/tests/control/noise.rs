//! Random streams and sample clocks.

use feeler_control::{ControllerSpec, Draws, Law, SampleClock, Stream};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

const DRAWS: u64 = 100_000;

/// Draws that must not change with the program, the platform or the generator's version: index, bits of the
/// uniform, normal.
const FROZEN: [(u64, u64, f64); 4] = [
    (0, 0x3fe8_8ff6_c39f_f9fc, -0.839_818_307_813_947),
    (1, 0x3fe8_194c_cedf_78bb, 0.638_621_771_282_528_5),
    (400_000_000, 0x3fea_6d7c_e571_db75, -0.322_923_102_271_376_77),
    (u64::MAX, 0x3fe9_fe2c_5075_7b03, 2.169_477_137_883_649_5),
];

#[test]
fn regress_draws_are_the_same_on_every_machine() {
    let stream = Stream::new(1, "sensors.force");
    for (index, uniform_bits, normal) in FROZEN {
        assert_eq!(stream.uniform_at(index).to_bits(), uniform_bits, "index {index}");
        // The platform's logarithm and cosine may differ in the last bit.
        assert!(
            (stream.normal_at(index) - normal).abs() <= 4.0 * f64::EPSILON,
            "index {index}: {:?}",
            stream.normal_at(index)
        );
    }
}

/// The bits of the uniform number are words 4 and 5 of the eight of an index, as an independent generator
/// counts them.
#[test]
fn truth_bits_are_those_of_chacha_with_eight_rounds() {
    let mut key = [0; 32];
    let name = "sensors.force";
    let hash = name.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    });
    let words = [7, hash, name.len() as u64, u64::from_le_bytes(*b"feeler-1")];
    key.chunks_exact_mut(8).zip(words).for_each(|(bytes, word)| bytes.copy_from_slice(&word.to_le_bytes()));
    let mut peer = ChaCha8Rng::from_seed(key);
    let stream = Stream::new(7, name);
    for index in (0..200).chain([1 << 33, (1 << 40) + 1, u64::MAX - 1, u64::MAX]) {
        peer.set_word_pos(u128::from(index) * 8 + 4);
        let uniform = (peer.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
        assert_eq!(stream.uniform_at(index).to_bits(), uniform.to_bits(), "index {index}");
    }
}

/// Even distances, repeated readings, jumps back and changes of distance.
#[test]
fn prop_numbers_drawn_ahead_are_those_of_their_index() {
    let stream = Stream::new(4, "sensors.force");
    let mut draws = Draws::new(stream.clone());
    let even = (0..50).map(|k| k * 1_000_000_000);
    let halves = (0..40).map(|k| 50_000_000_000 + k * 500_000_000);
    let odd = (0..200).map(|k: u64| k.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> (k % 7));
    let repeated = (0..30).map(|k| 7 * (k / 3));
    for index in even.chain(halves).chain(odd).chain(repeated).chain([u64::MAX - 1, u64::MAX, 0, 1, 2, 3]) {
        assert_eq!(draws.normal_at(index).to_bits(), stream.normal_at(index).to_bits(), "index {index}");
    }
}

/// Mean and variance of white draws are known to 1 / sqrt(n) and sqrt(2 / n); a correlation to 1 / sqrt(n).
/// Each at 4 sigma.
#[test]
fn truth_moments() {
    let n = DRAWS as f64;
    let stream = Stream::new(11, "sensors.encoder");
    let normals: Vec<f64> = (0..DRAWS).map(|i| stream.normal_at(i)).collect();
    let uniforms: Vec<f64> = (0..DRAWS).map(|i| stream.uniform_at(i)).collect();
    let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / n;
    assert!(mean(&mut normals.iter().copied()).abs() < 4.0 / n.sqrt());
    assert!((mean(&mut normals.iter().map(|x| x * x)) - 1.0).abs() < 4.0 * (2.0 / n).sqrt());
    // The fourth moment of a normal number is 3; its square's variance 96.
    assert!((mean(&mut normals.iter().map(|x| x.powi(4))) - 3.0).abs() < 4.0 * (96.0 / n).sqrt());
    assert!(mean(&mut normals.windows(2).map(|pair| pair[0] * pair[1])).abs() < 4.0 / n.sqrt());
    assert!(uniforms.iter().all(|u| (0.0..1.0).contains(u)));
    assert!((mean(&mut uniforms.iter().copied()) - 0.5).abs() < 4.0 / (12.0 * n).sqrt());
    let centred = |u: f64| (u - 0.5) * 12.0_f64.sqrt();
    assert!(mean(&mut normals.iter().zip(&uniforms).map(|(x, &u)| x * centred(u))).abs() < 4.0 / n.sqrt());
    let other = Stream::new(11, "sensors.force");
    assert!(mean(&mut normals.iter().zip(0..).map(|(x, i)| x * other.normal_at(i))).abs() < 4.0 / n.sqrt());
}

#[test]
#[expect(clippy::float_cmp, reason = "the same draw, to the bit")]
fn prop_a_draw_belongs_to_its_index() {
    let stream = Stream::new(2, "a");
    let pairs: [[f64; 2]; 40] = stream.normal_pairs_from(123);
    for (pair, offset) in pairs.iter().zip(0_u32..) {
        assert_eq!(pair[0], stream.normal_at(123 + u64::from(offset)));
    }
    assert_ne!(stream.normal_at(5), Stream::new(3, "a").normal_at(5));
    assert_ne!(stream.normal_at(5), Stream::new(2, "b").normal_at(5));
}

fn clock(jitter_s: f64, seed: u64) -> SampleClock {
    let spec = ControllerSpec { offset_s: 0.4e-3, jitter_s, ..ControllerSpec::new(Law::OpenLoop, 1e-3) };
    SampleClock::new(&spec, seed, "controllers.force").expect("the spec is sound")
}

#[test]
#[expect(clippy::float_cmp, reason = "without jitter the instants are the nominal ones")]
fn truth_sample_instants() {
    let even = clock(0.0, 1);
    assert_eq!(even.sample_time_s(0), 0.4e-3);
    assert_eq!(even.sample_time_s(1_000_000), 0.4e-3 + 1000.0);

    let sigma = 0.05e-3;
    let (n, jittered) = (20_000, clock(sigma, 1));
    let deviations = (1..=n).map(|k| jittered.sample_time_s(k) - even.sample_time_s(k));
    let power = deviations.map(|d| d * d).sum::<f64>() / n as f64;
    // The variance of n draws is known to sqrt(2 / n); 4 sigma.
    assert!((power / (sigma * sigma) - 1.0).abs() < 4.0 * (2.0 / n as f64).sqrt());
    assert_ne!(jittered.sample_time_s(7), clock(sigma, 2).sample_time_s(7));
}

#[test]
fn prop_samples_keep_their_order_under_any_jitter() {
    let wild = clock(5e-3, 1);
    let times: Vec<f64> = (0..2000).map(|k| wild.sample_time_s(k)).collect();
    assert!(times[0] >= 0.0);
    assert!(times.windows(2).all(|pair| pair[0] < pair[1]));
}
