//! Bags of ROS 2 in SQLite (`.db3`).

use std::collections::HashMap;
use std::path::Path;

use crate::error::LogError;
use crate::sqlite::{Database, Schema, Value};
use crate::topics::{Declared, Topics};

/// Reads the messages of a bag. Topics are numbered from `base` onwards.
pub(crate) fn read(path: &Path, topics: &mut Topics, base: u64) -> Result<(), LogError> {
    let mut database = Database::open(path)?;
    let tables = database.tables()?;
    let table = |name: &str| tables.iter().find(|table| table.name == name);
    let (Some(topic_table), Some(message_table)) = (table("topics"), table("messages")) else {
        let what = "this is a database, not a bag of ROS 2: it has no tables `topics` and `messages`";
        return Err(LogError::other(
            path,
            what,
            "write its table as CSV: `sqlite3 -header -csv FILE \"select * from NAME\"`",
        ));
    };
    let mut definitions: HashMap<String, (String, String)> = HashMap::new();
    if let Some(definition_table) = table("message_definitions") {
        let at = |name| definition_table.column(name);
        if let (Some(kind), Some(encoding), Some(text)) =
            (at("topic_type"), at("encoding"), at("encoded_message_definition"))
        {
            database.rows(definition_table, &mut |row| {
                let get = |i: usize| row.get(i).and_then(|value| value.text()).unwrap_or_default().to_owned();
                definitions.insert(get(kind), (get(encoding), get(text)));
                Ok(())
            })?;
        }
    }
    let need = |table: &Schema, name: &str| {
        table.column(name).ok_or_else(|| {
            let what = format!("its table `{}` has no column `{name}`", table.name);
            LogError::other(path, what, "convert it with `ros2 bag convert`, which writes the present form")
        })
    };
    let (id, name) = (need(topic_table, "id")?, need(topic_table, "name")?);
    let (kind, form) = (need(topic_table, "type")?, need(topic_table, "serialization_format")?);
    database.rows(topic_table, &mut |row| {
        let text = |i: usize| row.get(i).and_then(|value| value.text()).unwrap_or_default();
        let found = definitions.get(text(kind));
        let number = row.get(id).and_then(|value| value.int()).unwrap_or(0);
        topics.declare(
            base + number as u64,
            &Declared {
                name: text(name),
                encoding: text(form),
                schema_name: text(kind),
                schema_encoding: found.map_or("", |(encoding, _)| encoding),
                schema: found.map(|(_, text)| text.as_str()).filter(|text| !text.trim().is_empty()),
            },
        );
        Ok(())
    })?;
    let (topic, time) = (need(message_table, "topic_id")?, need(message_table, "timestamp")?);
    let data = need(message_table, "data")?;
    database.rows(message_table, &mut |row| {
        let int = |i: usize| row.get(i).copied().and_then(Value::int).unwrap_or(0);
        let bytes = row.get(data).copied().and_then(Value::bytes).unwrap_or_default();
        topics.push(path, base + int(topic) as u64, int(time), bytes)
    })
}
