//! Definitions in the sources of the types that the program writes as JSON.
//!
//! The sources are read line by line: rustfmt puts every field, comment and attribute on its own line.

use std::collections::BTreeMap;

use super::page::{files_under, text_of};

/// Folders of the crates whose types are written.
const FOLDERS: [&str; 6] = ["cli", "diagnosis", "files", "sim", "studies", "validation"];

/// A value in JSON.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Shape {
    Number,
    Integer,
    Flag,
    Text,
    NumberOrText,
    /// One of some texts, with the name of the type that lists them.
    OneOf(String, Vec<String>),
    OrNull(Box<Self>),
    List(Box<Self>),
    /// A list of fixed length.
    Several(Vec<Self>),
    /// Values by name.
    Map(Box<Self>),
    /// Fields, with the name of the type that defines them.
    Object(String, Vec<Field>),
}

/// A key of an object.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Field {
    pub(crate) name: String,
    /// Comment of the key.
    pub(crate) text: String,
    pub(crate) shape: Shape,
    pub(crate) may_be_absent: bool,
    /// Whether the keys of its object replace it.
    pub(crate) is_flat: bool,
}

/// Shapes by the names of generic parameters.
type Given = BTreeMap<String, Shape>;

#[derive(Clone, Copy)]
enum Kind {
    Struct,
    Enum,
    /// An implementation of `Serialize`.
    ByHand,
}

struct Source {
    file: String,
    kind: Kind,
    generics: Vec<String>,
    attributes: String,
    body: Vec<String>,
}

/// A line of a definition, with the comment and the attributes above it.
struct Item {
    text: String,
    attributes: String,
    code: String,
}

pub(crate) struct Definitions(BTreeMap<String, Vec<Source>>);

impl Definitions {
    pub(crate) fn read() -> Self {
        let mut found: BTreeMap<String, Vec<Source>> = BTreeMap::new();
        for file in FOLDERS.iter().flat_map(|folder| files_under(folder, ".rs")) {
            if !file.contains("/src/") {
                continue;
            }
            let text = text_of(&file);
            let mut lines = text.lines();
            let mut attributes = String::new();
            while let Some(line) = lines.next() {
                if line.starts_with("#[") {
                    attributes.push_str(line);
                    continue;
                }
                if line.starts_with("//") {
                    continue;
                }
                if let Some((kind, name)) = head(line) {
                    let body: Vec<String> =
                        lines.by_ref().take_while(|line| *line != "}").map(str::to_owned).collect();
                    let (name, generics) = name.split_once('<').unwrap_or((name, ""));
                    let generics = parts(generics.trim_end_matches('>')).into_iter().map(str::to_owned);
                    let source = Source {
                        file: file.clone(),
                        kind,
                        generics: generics.collect(),
                        attributes: attributes.clone(),
                        body,
                    };
                    if source.is_written() {
                        found.entry(name.to_owned()).or_default().push(source);
                    }
                }
                attributes.clear();
            }
        }
        Self(found)
    }

    /// The shape of a type that a mark on a page names: `keys of FILE: TYPE`.
    pub(crate) fn of_mark(&self, mark: &str) -> Option<Shape> {
        let (file, written) = mark.strip_prefix("keys of ")?.split_once(": ")?;
        Some(self.shape(written, file, &Given::new()))
    }

    /// The shape of a type as it is written in a file.
    fn shape(&self, written: &str, file: &str, given: &Given) -> Shape {
        let written = unborrowed(written);
        if let Some(shape) = given.get(written) {
            return shape.clone();
        }
        if let Some(inner) = written.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
            let is_length = |length: &str| length.chars().all(|c| c.is_alphanumeric() || c == '_');
            let sized = inner.rsplit_once("; ").filter(|(_, length)| is_length(length));
            let Some((item, length)) = sized else {
                return Shape::List(Box::new(self.shape(inner, file, given)));
            };
            let item = self.shape(item, file, given);
            return match length.parse::<usize>() {
                Ok(length) => Shape::Several(vec![item; length]),
                Err(_) => Shape::List(Box::new(item)),
            };
        }
        if let Some(inner) = written.strip_prefix('(').and_then(|rest| rest.strip_suffix(')')) {
            return Shape::Several(
                parts(inner).into_iter().map(|part| self.shape(part, file, given)).collect(),
            );
        }
        let (name, arguments) =
            written.strip_suffix('>').and_then(|rest| rest.split_once('<')).unwrap_or((written, ""));
        let name = name.rsplit("::").next().unwrap_or(name);
        let arguments: Vec<Shape> =
            parts(arguments).into_iter().map(|part| self.shape(part, file, given)).collect();
        let last = || Box::new(arguments.last().cloned().unwrap_or_else(|| panic!("{file}: `{written}`")));
        match name {
            "Option" => Shape::OrNull(last()),
            "Vec" => Shape::List(last()),
            "BTreeMap" | "IndexMap" => Shape::Map(last()),
            "f64" => Shape::Number,
            "i64" | "isize" | "u8" | "u32" | "u64" | "usize" => Shape::Integer,
            "bool" => Shape::Flag,
            "str" | "String" => Shape::Text,
            _ => self.named(name, file, arguments),
        }
    }

    /// The shape of a type of the project. If several have this name, it is the one in the nearest file.
    fn named(&self, name: &str, file: &str, arguments: Vec<Shape>) -> Shape {
        let sources = self.0.get(name).unwrap_or_else(|| panic!("{file}: nothing writes `{name}`"));
        let near = |source: &&Source| {
            source.file.split('/').zip(file.split('/')).take_while(|(a, b)| a == b).count()
        };
        let nearest = sources.iter().map(|source| near(&source)).max();
        let mut found = sources.iter().filter(|source| Some(near(source)) == nearest);
        let source = found.next().unwrap();
        assert!(found.next().is_none(), "{file}: `{name}` may be one of several types");
        let id = format!("{}: {name}", source.file);
        match source.kind {
            Kind::ByHand if source.calls("serialize_f64") => Shape::NumberOrText,
            Kind::ByHand => Shape::Text,
            Kind::Struct => {
                let given = source.generics.iter().cloned().zip(arguments).collect();
                Shape::Object(id, self.fields(source, 4, &given))
            }
            Kind::Enum => self.choice(id, source),
        }
    }

    /// An enum: one of some texts or, if its variants have fields, an object with a tag.
    fn choice(&self, id: String, source: &Source) -> Shape {
        assert!(source.attributes.contains("kebab-case"), "{id} is not written in kebab case");
        let variants = items(&source.body, 4).into_iter().map(|item| item.code);
        let variants = variants.filter(|code| code.starts_with(char::is_uppercase));
        let names: Vec<String> = variants.map(|code| kebab(&code)).collect();
        let Some(tag) = quoted(&source.attributes, "tag = ") else { return Shape::OneOf(id, names) };
        let mut fields = vec![Field {
            name: tag.to_owned(),
            text: "Which of these.".to_owned(),
            shape: Shape::OneOf(format!("{id}.{tag}"), names),
            may_be_absent: false,
            is_flat: false,
        }];
        for field in self.fields(source, 8, &Given::new()) {
            if !fields.iter().any(|known| known.name == field.name) {
                fields.push(Field { may_be_absent: true, ..field });
            }
        }
        Shape::Object(id, fields)
    }

    fn fields(&self, source: &Source, depth: usize, given: &Given) -> Vec<Field> {
        let mut found = Vec::new();
        for Item { text, attributes, code } in items(&source.body, depth) {
            let Some((name, written)) = code.strip_suffix(',').and_then(|code| code.split_once(": ")) else {
                continue;
            };
            if attributes.contains("(skip)") {
                continue;
            }
            let name = name.rsplit(' ').next().unwrap_or(name);
            assert!(!text.is_empty(), "{}: `{name}` has no comment", source.file);
            let may_be_absent = attributes.contains("skip_serializing_if");
            let nothing = if may_be_absent { "absent" } else { "`null`" };
            let shape = match self.shape(written, &source.file, given) {
                Shape::OrNull(shape) if may_be_absent => *shape,
                shape => shape,
            };
            found.push(Field {
                name: quoted(&attributes, "rename = ").unwrap_or(name).to_owned(),
                text: text
                    .replace("`None`", nothing)
                    .replace("[`Self::", "[`")
                    .replace("[`", "`")
                    .replace("`]", "`"),
                shape,
                may_be_absent,
                is_flat: attributes.contains("flatten"),
            });
        }
        assert!(!found.is_empty(), "{} has a type without fields", source.file);
        found
    }
}

impl Source {
    fn calls(&self, function: &str) -> bool {
        self.body.iter().any(|line| line.contains(function))
    }

    /// Whether serde writes the type, by a derived implementation or by one that gives a text or a number.
    fn is_written(&self) -> bool {
        match self.kind {
            Kind::Struct | Kind::Enum => self.attributes.contains("Serialize"),
            Kind::ByHand => self.calls("serialize_str") || self.calls("collect_str"),
        }
    }
}

/// The definition that a line begins, and its name.
fn head(line: &str) -> Option<(Kind, &str)> {
    let line = line.strip_suffix(" {")?;
    if line.starts_with("impl") {
        return line.split_once("Serialize for ").map(|(_, name)| (Kind::ByHand, name));
    }
    let item = match line.strip_prefix("pub") {
        Some(rest) => rest.split_once(' ')?.1,
        None => line,
    };
    let of = |word: &str, kind: Kind| item.strip_prefix(word).map(|name| (kind, name));
    of("struct ", Kind::Struct).or_else(|| of("enum ", Kind::Enum))
}

/// The lines of a definition at a depth.
fn items(body: &[String], depth: usize) -> Vec<Item> {
    let mut found = Vec::new();
    let (mut text, mut attributes) = (Vec::new(), String::new());
    for line in body {
        let code = line.trim();
        if code.is_empty() || line.len() - line.trim_start().len() != depth {
            continue;
        }
        if let Some(comment) = code.strip_prefix("///") {
            text.push(comment.trim());
        } else if code.starts_with("#[") {
            attributes.push_str(code);
        } else {
            let attributes = std::mem::take(&mut attributes);
            found.push(Item { text: text.join(" "), attributes, code: code.to_owned() });
            text.clear();
        }
    }
    found
}

/// The text in quotes after a word of an attribute.
fn quoted<'a>(attributes: &'a str, word: &str) -> Option<&'a str> {
    attributes.split_once(word)?.1.split('"').nth(1)
}

/// A type without its borrow and lifetime.
fn unborrowed(written: &str) -> &str {
    let Some(rest) = written.trim().strip_prefix('&') else { return written.trim() };
    if rest.starts_with('\'') { rest.split_once(' ').map_or(rest, |(_, rest)| rest) } else { rest }
}

/// The parts between commas outside of brackets, without lifetimes.
fn parts(text: &str) -> Vec<&str> {
    let (mut found, mut depth, mut begin) = (Vec::new(), 0, 0);
    for (at, c) in text.char_indices() {
        match c {
            '<' | '[' | '(' => depth += 1,
            '>' | ']' | ')' => depth -= 1,
            ',' if depth == 0 => {
                found.push(&text[begin..at]);
                begin = at + 1;
            }
            _ => {}
        }
    }
    found.push(&text[begin..]);
    found.into_iter().map(str::trim).filter(|part| !part.is_empty() && !part.starts_with('\'')).collect()
}

/// The name of a variant in a file.
fn kebab(code: &str) -> String {
    let mut name = String::new();
    for c in code.chars().take_while(|c| c.is_alphanumeric()) {
        if c.is_uppercase() && !name.is_empty() {
            name.push('-');
        }
        name.extend(c.to_lowercase());
    }
    name
}
