//! Tables of text in the forms that loggers write.

use std::path::Path;

use feeler_logs::{ClockUnit, LogError, Pick, Run, on_one_grid, read_file, sources};
use feeler_problem::Remedy;

fn folder(files: &[(&str, &[u8])]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, bytes) in files {
        std::fs::write(folder.path().join(name), bytes).expect("written");
    }
    folder
}

fn read(name: &str, bytes: &[u8]) -> Result<Run, LogError> {
    let folder = folder(&[(name, bytes)]);
    read_file(&folder.path().join(name), None).map(|mut runs| runs.remove(0))
}

fn columns(run: &Run) -> Vec<(&str, &[f64])> {
    run.tables.iter().flat_map(|t| t.columns.iter().map(|c| (c.name.as_str(), c.values.as_slice()))).collect()
}

#[test]
fn truth_one_table_in_every_shape_holds_the_same_numbers() {
    let utf_16 = |text: &str, mark: u16| -> Vec<u8> {
        std::iter::once(mark).chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect()
    };
    let semicolons = "t_s;x\n0,0;1,5\n0,25;-2,5\n0,5;3e-3\n";
    let shapes: [(&str, Vec<u8>); 9] = [
        ("commas", b"t_s,x\n0.0,1.5\n0.25,-2.5\n0.5,3e-3\n".to_vec()),
        ("semicolons and decimal commas", semicolons.into()),
        ("tabs", b"t_s\tx\n0.0\t1.5\n0.25\t-2.5\n0.5\t3e-3\n".to_vec()),
        ("blanks", b"  t_s     x\n  0.0   1.5\n  0.25 -2.5\n 0.5 3e-3\n".to_vec()),
        ("UTF-16", utf_16(semicolons, 0xfeff)),
        ("UTF-8 with its mark", b"\xef\xbb\xbft_s,x\r\n0.0,1.5\r\n0.25,-2.5\r\n0.5,3e-3\r\n".to_vec()),
        ("remarks", b"# made by a logger\nt_s,x\n0.0,1.5\n# again\n0.25,-2.5\n0.5,3e-3\n".to_vec()),
        ("microseconds", b"time_us,x\n0,1.5\n250000,-2.5\n500000,3e-3\n".to_vec()),
        ("another order", b"x,t_s\n1.5,0.0\n-2.5,0.25\n3e-3,0.5\n".to_vec()),
    ];
    for (shape, bytes) in shapes {
        let run = read("a.csv", &bytes).unwrap_or_else(|error| panic!("{shape}: {error}"));
        assert_eq!(run.tables[0].times_s, [0.0, 0.25, 0.5], "{shape}");
        assert_eq!(columns(&run), [("x", &[1.5, -2.5, 3e-3][..])], "{shape}");
    }
}

#[test]
fn truth_clocks_of_any_unit_are_seconds_from_their_first_row_or_their_zero() {
    for (text, unit, times) in [
        (
            "timestamp,x\n1714564800.25,1\n1714564800.75,2\n1714564801.25,3\n",
            ClockUnit::Seconds,
            [0.0, 0.5, 1.0],
        ),
        (
            "timestamp,x\n1714564800250,1\n1714564800750,2\n1714564801250,3\n",
            ClockUnit::Milliseconds,
            [0.0, 0.5, 1.0],
        ),
        (
            "t,x\n1714564800250000001,1\n1714564800750000001,2\n1714564801250000001,3\n",
            ClockUnit::Nanoseconds,
            [0.0, 0.5, 1.0],
        ),
        (
            "time,x\n2024-05-01T12:00:00Z,1\n2024-05-01T12:00:00.5Z,2\n2024-05-01T12:00:01Z,3\n",
            ClockUnit::Nanoseconds,
            [0.0, 0.5, 1.0],
        ),
        ("timestamp,x\n0,1\n20000,2\n40000,3\n", ClockUnit::Microseconds, [0.0, 0.02, 0.04]),
        ("Time [ms],x\n0,1\n20,2\n40,3\n", ClockUnit::Milliseconds, [0.0, 0.02, 0.04]),
    ] {
        let run = read("a.csv", text.as_bytes()).expect("a table");
        let table = &run.tables[0];
        assert_eq!(table.clock.as_ref().map(|clock| clock.unit), Some(unit), "{text}");
        assert_eq!(table.times_s, times, "{text}");
    }
}

#[test]
fn truth_lists_in_cells_are_columns_that_a_file_beside_them_names() {
    let text = "type,timestamp,positions\nA,0,\"[1.0, 2.0]\"\nA,20000,\"[1.5, 2.5]\"\nA,40000,\"[1.25]\"\n";
    let files: [(&str, &[u8]); 2] = [("a.csv", text.as_bytes()), ("joint_list.txt", b"Pan\nLift\n")];
    let named = folder(&files);
    let run = read_file(&named.path().join("a.csv"), None).expect("a table").remove(0);
    let (_, pan) = run.find("positions[Pan]").expect("it is there");
    assert_eq!(pan.values, [1.0, 1.5, 1.25]);
    let (_, lift) = run.find("positions[Lift]").expect("it is there");
    assert!(lift.values[..2] == [2.0, 2.5] && lift.values[2].is_nan());
    assert_eq!(
        (lift.number, run.find("3").map(|(_, column)| column.name.clone())),
        (3, Some("positions[Pan]".into()))
    );
    // Items count from zero with names, too.
    let numbered = |name: &str| run.find(name).map(|(_, column)| column.name.clone());
    assert_eq!(numbered("positions[1]"), Some("positions[Lift]".into()));
    assert_eq!([numbered("positions[2]"), numbered("position[0]")], [None, None]);
    let plain = read("a.csv", text.as_bytes()).expect("a table");
    assert!(plain.find("positions[1]").is_some());
}

#[test]
fn truth_empty_cells_are_rows_of_other_channels() {
    let text = "t_s,fast,slow\n0.0,1,10\n0.1,2,\n0.2,3,\n0.3,4,40\n0.4,5,\n0.5,6,\n0.6,7,70\n";
    let run = read("a.csv", text.as_bytes()).expect("a table");
    assert_eq!(run.find("slow").map(|(_, column)| column.present()), Some(3));
    let pick = |is_held| [Pick { name: "fast", is_held: false }, Pick { name: "slow", is_held }];
    let series = on_one_grid(Path::new("a.csv"), &run, &pick(false)).expect("series");
    assert_eq!(series.times_s.len(), 7);
    let line: Vec<f64> = (0..7).map(|k| 10.0 + 10.0 * f64::from(k)).collect();
    let off = series.values[1].iter().zip(&line).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    // A few roundings of numbers up to 70.
    assert!(off < 1e-12 && series.notes[0].contains("3 readings"), "{off} {:?}", series.notes);
    let held = on_one_grid(Path::new("a.csv"), &run, &pick(true)).expect("series");
    assert_eq!(held.values[1], [10.0, 10.0, 10.0, 40.0, 40.0, 40.0, 70.0]);
}

#[test]
fn truth_files_of_one_run_keep_their_clocks() {
    let files: [(&str, &[u8]); 2] = [
        ("command.csv", b"timestamp,u\n1714564800000,1\n1714564800020,2\n1714564800040,3\n"),
        ("state.csv", b"t,q\n1714564800.010,10\n1714564800.030,20\n1714564800.050,30\n1714564800.070,40\n"),
    ];
    let folder = folder(&files);
    let sources = sources(&[folder.path()]).expect("logs");
    assert_eq!(sources.len(), 1, "two headers: one run");
    let run = sources[0].read().expect("a run").remove(0);
    let picks = [Pick { name: "u", is_held: true }, Pick { name: "q", is_held: false }];
    let series = on_one_grid(folder.path(), &run, &picks).expect("series");
    // At 10, 30, 50 and 70 ms of the first clock: the command held then.
    assert_eq!(series.values[0], [1.0, 2.0, 3.0, 3.0]);
    assert_eq!(series.values[1], [10.0, 20.0, 30.0, 40.0]);
}

#[test]
fn truth_tables_with_the_same_header_are_runs_of_their_own() {
    let files: [(&str, &[u8]); 2] = [("a.csv", b"t_s,q\n0,1\n1,2\n"), ("b.csv", b"t_s,q\n0,1\n1,2\n")];
    assert_eq!(sources(&[folder(&files).path()]).expect("logs").len(), 2);
}

#[test]
fn truth_a_table_without_a_clock_says_what_to_do() {
    let text = "Joint_1,Joint_2\n1.0,5.0\n0.5,5.0\n1.5,5.0\n";
    let mut run = read("a.csv", text.as_bytes()).expect("a table");
    let pick = [Pick { name: "Joint_1", is_held: false }];
    let error = on_one_grid(Path::new("a.csv"), &run, &pick).expect_err("no clock");
    assert!(
        error.to_string().contains("no column of it is a clock") && error.remedy().contains("--rate"),
        "{error}"
    );
    run.set_rate(100.0);
    let series = on_one_grid(Path::new("a.csv"), &run, &pick).expect("series");
    assert_eq!(series.times_s, [0.0, 0.01, 0.02]);
    let missing = on_one_grid(Path::new("a.csv"), &run, &[Pick { name: "hip", is_held: false }]);
    assert!(missing.expect_err("missing").to_string().contains("`hip`"));
}

#[test]
fn truth_text_where_a_number_belongs_is_placed() {
    let run = read("a.csv", b"t_s,x\n0,1\n1,oops\n2,3\n3,oops\n").expect("a table");
    let bad = run.tables[0].columns[0].bad.clone().expect("bad cells");
    assert_eq!((bad.first, bad.count, run.tables[0].rows_before), (1, 2, 1));
}
