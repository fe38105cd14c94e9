//! Messages with lists of names in several structures.

use std::collections::BTreeMap;
use std::io::Cursor;

/// Bytes in CDR, little endian.
#[derive(Default)]
struct Cdr(Vec<u8>);

impl Cdr {
    fn put(&mut self, bytes: &[u8]) {
        self.0.resize(self.0.len().next_multiple_of(bytes.len()), 0);
        self.0.extend(bytes);
    }

    fn count(&mut self, count: usize) {
        self.put(&(count as u32).to_le_bytes());
    }

    fn texts(&mut self, texts: &[&str]) {
        self.count(texts.len());
        for text in texts {
            self.count(text.len() + 1);
            self.0.extend(text.as_bytes());
            self.0.push(0);
        }
    }
}

/// As many interfaces as joints: the length of a list alone does not tell whose names it has.
#[test]
fn truth_values_of_a_dynamic_joint_state_have_the_names_of_joint_and_interface() {
    let definition = "string[] joint_names\ncontrol_msgs/InterfaceValue[] interface_values\n\
        ================================================================================\n\
        MSG: control_msgs/InterfaceValue\nstring[] interface_names\nfloat64[] values";
    let mut bytes = Cursor::new(Vec::new());
    let mut writer = mcap::WriteOptions::new().create(&mut bytes).expect("a writer");
    let schema = writer.add_schema("control_msgs/msg/DynamicJointState", "ros2msg", definition.as_bytes());
    let channel = writer
        .add_channel(schema.expect("a schema"), "/dynamic_joint_states", "cdr", &BTreeMap::new())
        .expect("a channel");
    for k in 0..3_u32 {
        let mut message = Cdr::default();
        message.texts(&["pan", "lift"]);
        message.count(2);
        for joint in 0..2 {
            message.texts(&["position", "effort"]);
            message.count(2);
            for of in [0.0, 0.5] {
                message.put(&(f64::from(10 * joint + k) + of).to_le_bytes());
            }
        }
        let (log_time, publish_time) = (u64::from(k) * 1_000_000, 0);
        let header =
            mcap::records::MessageHeader { channel_id: channel, sequence: k, log_time, publish_time };
        let message = [&[0, 1, 0, 0], &message.0[..]].concat();
        writer.write_to_known_channel(&header, &message).expect("written");
    }
    writer.finish().expect("finished");
    drop(writer);
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("a.mcap");
    std::fs::write(&file, bytes.into_inner()).expect("written");
    let runs = feeler_logs::read_file(&file, None).unwrap_or_else(|error| panic!("{error}"));
    let columns = runs[0].tables[0].columns.iter().map(|column| (column.name.as_str(), column.values[2]));
    let of = |joint: &str, interface: &str| format!("interface_values[{joint}].values[{interface}]");
    let expected = [("pan", "position", 2.0), ("pan", "effort", 2.5), ("lift", "position", 12.0)]
        .map(|(joint, interface, value)| (of(joint, interface), value));
    let found: Vec<(String, f64)> = columns.map(|(name, x)| (name.to_owned(), x)).collect();
    assert_eq!(found[..3], expected);
}
