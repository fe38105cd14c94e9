//! Every figure of the paper can be drawn.

use feeler_validation::figures::figures;

#[test]
fn truth_every_figure_is_there_with_labels_and_caption() {
    let all = figures().unwrap();
    let names: Vec<&str> = all.iter().map(|figure| figure.name.as_str()).collect();
    let expected = [
        "fig04", "fig05", "fig07", "fig08", "fig10", "fig11", "fig13", "fig14", "fig15", "fig16", "fig17",
        "fig18",
    ];
    assert_eq!(names, expected);
    // The base's pole and zero lie 0.16 Hz apart, and are drawn once more.
    assert_eq!(
        all.iter()
            .filter(|figure| figure.panels.iter().any(|panel| panel.x.label.contains("magnified")))
            .count(),
        1
    );
    for figure in &all {
        let svg = figure.svg();
        assert!(svg.starts_with("<svg") && svg.ends_with("</svg>\n"), "{}", figure.name);
        assert!(!svg.contains("NaN"), "{}", figure.name);
        assert!(
            figure.panels.iter().all(|panel| panel.x.label.contains('(') && panel.y.label.contains('(')),
            "{}",
            figure.name
        );
        assert!(svg.len() < 300_000, "{}: {} bytes", figure.name, svg.len());
    }
}
