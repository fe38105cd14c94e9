//! Frequency responses of drives with a loop of their own.

use feeler_files::{Draft, template};
use feeler_problem::Remedy;
use feeler_studies::frf::{ExcitationKind, FrfRequest, simulate};

use crate::common::file;

/// An experiment that the file describes is the default; any other that is asked for stays.
#[test]
fn truth_a_machine_is_excited_as_its_file_says() {
    let request = |name: &str, request: FrfRequest| request.excited_as(&file(name, &[]).scenario);
    let played = request("paper/flexible-multisine.toml", FrfRequest::default());
    assert_eq!(played.excitation, Some(ExcitationKind::Multisine));
    assert_eq!(
        [played.from_hz, played.to_hz, played.rms, played.period_s],
        [2.0, 400.0, 20.0, 1.0].map(Some)
    );
    let noise = FrfRequest { excitation: Some(ExcitationKind::WhiteNoise), ..FrfRequest::default() };
    assert_eq!(request("paper/flexible-multisine.toml", noise.clone()), noise);
    assert_eq!(request("chatter/sustained.toml", FrfRequest::default()), FrfRequest::default());
}

/// A target is held for a whole number of the servo's samples, of 2 ms, or it has no response.
#[test]
fn regress_targets_of_a_sampled_servo_are_held_for_whole_samples() {
    let servo = template("servo").expect("a template").text;
    let respond = |hold_s: Option<f64>| {
        let mut draft = Draft::parse(servo, "servo.toml").expect("a draft");
        draft.set("controllers.aim.period=0.005").expect("a period");
        let scenario = draft.build().expect("a scenario").scenario;
        let request = FrfRequest {
            excitation: Some(ExcitationKind::SteppedSine),
            points: Some(2),
            from_hz: Some(1.0),
            to_hz: Some(3.0),
            rms: Some(0.05),
            hold_s,
            ..FrfRequest::default()
        };
        simulate(&scenario, &request)
    };
    // By default the hold is that of the controller, 5 ms, rounded up to a whole number of samples.
    assert!((respond(None).expect("a response").hold_s - 6e-3).abs() < 1e-12);
    let error = respond(Some(5e-3)).expect_err("it is not a whole number");
    assert!(error.to_string().contains("not a whole number of samples of `servo`"), "{error}");
    assert!(error.remedy().contains("--hold"));
    // The loop follows its target, and the measured response is that of theory, not that from a force.
    let response = respond(Some(4e-3)).expect("a response");
    for (measured, linear) in response.estimate.response.iter().zip(&response.linear) {
        // Steps of the encoder are 2 % of this motion, and an average over a second meets hundreds of them.
        assert!((measured - linear).norm() < 0.01 * linear.norm(), "{measured} {linear}");
    }
}
