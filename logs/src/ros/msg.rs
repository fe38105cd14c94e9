//! Definitions in the form of `.msg` files, as in the schema encoding `ros2msg`.

use indexmap::IndexMap;

use super::definition::{Base, Definition, DefinitionError, Field, Many, Struct, short_name};

/// Types whose definition a schema may omit.
const BUILTIN: [(&str, &str); 3] = [
    ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec"),
    ("builtin_interfaces/Duration", "int32 sec\nuint32 nanosec"),
    ("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id"),
];

/// The definition of `name`; other required ones follow in the text after lines of `=`.
pub(super) fn parse(name: &str, text: &str) -> Result<Definition, DefinitionError> {
    let mut sections: IndexMap<String, Vec<&str>> = IndexMap::new();
    let mut current = short_name(name);
    let mut lines = text.lines().peekable();
    while let Some(line) = lines.next() {
        if line.len() >= 8 && line.trim().bytes().all(|b| b == b'=') {
            let next = lines.next().unwrap_or_default();
            let Some(other) = next.trim().strip_prefix("MSG:") else {
                return Err(DefinitionError(format!(
                    "`MSG: package/Type` is missing after a line of `=`: `{next}`"
                )));
            };
            current = short_name(other.trim());
            continue;
        }
        sections.entry(current.clone()).or_default().push(line);
    }
    sections.entry(short_name(name)).or_default();
    for (builtin, body) in BUILTIN {
        sections.entry(builtin.into()).or_insert_with(|| body.lines().collect());
    }
    let mut structs = Vec::new();
    for (own, lines) in &sections {
        let mut fields = Vec::new();
        for line in lines {
            if let Some(field) = field(own, line, &sections)? {
                fields.push(field);
            }
        }
        structs.push(Struct { name: own.clone(), fields });
    }
    let root = sections.get_index_of(&short_name(name)).unwrap_or(0);
    Definition { structs, root }.checked()
}

/// The field of a line; `None` for comments and constants.
fn field(
    own: &str,
    line: &str,
    known: &IndexMap<String, Vec<&str>>,
) -> Result<Option<Field>, DefinitionError> {
    let line = line.split('#').next().unwrap_or_default().trim();
    let Some((kind, rest)) = line.split_once(char::is_whitespace) else {
        return if line.is_empty() {
            Ok(None)
        } else {
            Err(DefinitionError(format!("{own}: `{line}` has no name")))
        };
    };
    let rest = rest.trim();
    let name = rest.split(|c: char| c.is_whitespace() || c == '=').next().unwrap_or_default();
    if rest[name.len()..].trim_start().starts_with('=') {
        return Ok(None);
    }
    let (kind, many) = match kind.find('[') {
        None => (kind, Many::One),
        Some(at) => (
            &kind[..at],
            many(&kind[at..]).ok_or_else(|| DefinitionError(format!("{own}: `{kind}` is not an array")))?,
        ),
    };
    let bare = kind.split('<').next().unwrap_or_default();
    let base = match bare {
        "bool" => Base::Bool,
        "byte" | "uint8" | "char" => Base::U8,
        "int8" => Base::I8,
        "uint16" => Base::U16,
        "int16" => Base::I16,
        "uint32" => Base::U32,
        "int32" => Base::I32,
        "uint64" => Base::U64,
        "int64" => Base::I64,
        "float32" => Base::F32,
        "float64" => Base::F64,
        "string" => Base::Text,
        "wstring" => {
            return Err(DefinitionError(format!(
                "{own}: `{name}` is a wstring, whose encoding is not standardised"
            )));
        }
        other => Base::Struct(find(own, other, known)?),
    };
    Ok(Some(Field { name: name.into(), base, many }))
}

fn many(brackets: &str) -> Option<Many> {
    let inner = brackets.strip_prefix('[')?.strip_suffix(']')?;
    match inner.strip_prefix("<=") {
        Some(bound) => bound.parse::<usize>().ok().map(|_| Many::Sequence),
        None if inner.is_empty() => Some(Many::Sequence),
        None => inner.parse().ok().map(Many::Fixed),
    }
}

fn find(own: &str, name: &str, known: &IndexMap<String, Vec<&str>>) -> Result<usize, DefinitionError> {
    let package = own.split('/').next().unwrap_or_default();
    let full = short_name(name);
    let local = format!("{package}/{full}");
    let header = (name == "Header").then_some("std_msgs/Header");
    [Some(full.as_str()), Some(local.as_str()), header]
        .into_iter()
        .flatten()
        .find_map(|name| known.get_index_of(name))
        .ok_or_else(|| DefinitionError(format!("the definition of `{name}` is missing, which {own} holds")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_fields_constants_and_bounds_are_told_apart() {
        let text = "# a remark\nuint8 A=1\nstring B = \"x # y\"\nfloat64 x 1.5 # with a default\n\
            string<=10[<=3] names\nOther[2] others\nstd_msgs/msg/Header header\n\
            ================================================================================\n\
            MSG: demo/Other\nint32[] values\n";
        let found = parse("demo/msg/Whole", text).expect("a definition");
        let root = &found.structs[found.root];
        assert_eq!(root.name, "demo/Whole");
        let shown: Vec<_> = root.fields.iter().map(|f| (f.name.as_str(), f.base, f.many)).collect();
        let at = |name: &str| found.structs.iter().position(|s| s.name == name).expect("it is there");
        assert_eq!(
            shown,
            [
                ("x", Base::F64, Many::One),
                ("names", Base::Text, Many::Sequence),
                ("others", Base::Struct(at("demo/Other")), Many::Fixed(2)),
                ("header", Base::Struct(at("std_msgs/Header")), Many::One),
            ]
        );
    }

    #[test]
    fn truth_definitions_that_cannot_be_are_refused() {
        for (text, why) in [
            ("Self x", "holds itself"),
            ("Missing x", "`Missing` is missing"),
            ("float64[9999999] x", "more than"),
            ("wstring x", "wstring"),
            ("float64", "has no name"),
            ("float64[a] x", "is not an array"),
        ] {
            let error = parse("demo/Self", text).expect_err(text);
            assert!(error.0.contains(why), "{error}");
        }
    }
}
