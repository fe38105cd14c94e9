//! Reports on mistakes, as the user reads them.

use feeler_files::Document;

#[test]
fn truth_all_mistakes_of_a_file_are_reported_together() {
    let error = Document::parse(include_str!("../data/ten-mistakes.txt"), "ten-mistakes.toml").unwrap_err();
    insta::assert_snapshot!(error.report(false));
}

#[test]
fn truth_what_is_no_toml_is_reported_alike() {
    let error =
        Document::parse("[bodies.motor]\nmass = = 3\n[bodies.motor]\nmass = 2\n", "broken.toml").unwrap_err();
    insta::assert_snapshot!(error.report(false));
}

#[test]
fn truth_problems_are_data_too() {
    let error = Document::parse("[bodies.motor]\nmass = -3.0\n", "light.toml").unwrap_err();
    insta::assert_snapshot!(serde_json::to_string_pretty(&error.to_json()).unwrap());
}
