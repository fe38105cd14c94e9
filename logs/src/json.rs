//! Numbers of a JSON message, with the path of each.

use serde_json::Value;

/// Every number of a message, by its dotted path.
pub(crate) fn numbers(message: &[u8]) -> Result<Vec<(String, f64)>, serde_json::Error> {
    let value: Value = serde_json::from_slice(message)?;
    let mut numbers = Vec::new();
    flatten(&value, String::new(), &mut numbers);
    Ok(numbers)
}

fn flatten(value: &Value, name: String, numbers: &mut Vec<(String, f64)>) {
    match value {
        Value::Number(number) => numbers.push((name, number.as_f64().unwrap_or(f64::NAN))),
        Value::Bool(flag) => numbers.push((name, f64::from(u8::from(*flag)))),
        Value::Object(fields) => {
            for (field, value) in fields {
                let name = if name.is_empty() { field.clone() } else { format!("{name}.{field}") };
                flatten(value, name, numbers);
            }
        }
        Value::Array(items) => {
            for (i, value) in items.iter().enumerate() {
                flatten(value, format!("{name}[{i}]"), numbers);
            }
        }
        Value::Null | Value::String(_) => {}
    }
}
