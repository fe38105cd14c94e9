//! Definitions in OMG IDL, as in the schema encoding `ros2idl`: the subset that ROS 2 writes.

use indexmap::IndexMap;

use super::definition::{Base, Definition, DefinitionError, Field, Many, Struct, short_name};

/// A type as written, before names are resolved.
#[derive(Clone, Debug)]
struct Written {
    /// Name of a primitive or of another type.
    name: String,
    many: Many,
    /// The type of the items, if these are lists themselves.
    inner: Option<Box<Written>>,
}

#[derive(Default)]
struct Parser<'a> {
    tokens: Vec<&'a str>,
    at: usize,
    scope: Vec<&'a str>,
    structs: IndexMap<String, Vec<(String, Written)>>,
    types: IndexMap<String, Written>,
}

/// The definition of `name`, with all types in the text.
pub(super) fn parse(name: &str, text: &str) -> Result<Definition, DefinitionError> {
    let mut parser = Parser { tokens: tokens(text), ..Parser::default() };
    while parser.at < parser.tokens.len() {
        parser.declaration()?;
    }
    let wanted = short_name(name);
    let mut structs: Vec<Struct> =
        parser.structs.keys().map(|name| Struct { name: short_name(name), fields: Vec::new() }).collect();
    for (i, (own, members)) in parser.structs.iter().enumerate() {
        for (member, written) in members {
            let field = parser.resolve(own, member, written, &mut structs, 0)?;
            structs[i].fields.push(field);
        }
    }
    let root = structs.iter().position(|found| found.name == wanted);
    let root = root.ok_or_else(|| DefinitionError(format!("the definition of `{wanted}` is missing")))?;
    Definition { structs, root }.checked()
}

/// Largest depth of nested type aliases.
const MOST_DEEP: usize = 32;

impl<'a> Parser<'a> {
    fn peek(&self) -> &'a str {
        self.tokens.get(self.at).copied().unwrap_or("")
    }

    fn next(&mut self) -> &'a str {
        let token = self.peek();
        self.at += 1;
        token
    }

    fn expect(&mut self, wanted: &str) -> Result<(), DefinitionError> {
        let found = self.next();
        if found == wanted {
            return Ok(());
        }
        let shown = if found.is_empty() { "the end" } else { found };
        Err(DefinitionError(format!("IDL: `{wanted}` is missing before `{shown}`")))
    }

    fn skip_past(&mut self, last: &str) {
        while self.at < self.tokens.len() && self.next() != last {}
    }

    fn annotations(&mut self) {
        while self.peek() == "@" {
            self.at += 2;
            while self.peek() == "::" {
                self.at += 2;
            }
            if self.peek() == "(" {
                let mut depth = 0;
                while self.at < self.tokens.len() {
                    match self.next() {
                        "(" => depth += 1,
                        ")" => depth -= 1,
                        _ => {}
                    }
                    if depth == 0 {
                        break;
                    }
                }
            }
        }
    }

    fn declaration(&mut self) -> Result<(), DefinitionError> {
        self.annotations();
        match self.next() {
            "module" => {
                let name = self.next();
                self.scope.push(name);
                self.expect("{")?;
                while !matches!(self.peek(), "}" | "") {
                    self.declaration()?;
                }
                self.expect("}")?;
                self.scope.pop();
                self.skip_if(";");
            }
            "struct" => self.structure()?,
            "typedef" => {
                let written = self.written()?;
                let (name, written) = self.declarator(written)?;
                self.expect(";")?;
                let full = self.full(name);
                self.types.insert(full, written);
            }
            "enum" => {
                let full = self.full_next();
                self.skip_past("}");
                self.skip_if(";");
                self.types.insert(full, Written { name: "uint32".into(), many: Many::One, inner: None });
            }
            "const" => self.skip_past(";"),
            "" | ";" => {}
            other => {
                return Err(DefinitionError(format!("IDL: `{other}` does not begin a known definition")));
            }
        }
        Ok(())
    }

    fn skip_if(&mut self, token: &str) {
        if self.peek() == token {
            self.at += 1;
        }
    }

    fn full(&self, name: &str) -> String {
        let mut parts = self.scope.clone();
        parts.push(name);
        parts.join("::")
    }

    fn full_next(&mut self) -> String {
        let name = self.next();
        self.full(name)
    }

    fn structure(&mut self) -> Result<(), DefinitionError> {
        let full = self.full_next();
        self.expect("{")?;
        let mut members = Vec::new();
        loop {
            self.annotations();
            if matches!(self.peek(), "}" | "") {
                break;
            }
            let written = self.written()?;
            loop {
                let (name, written) = self.declarator(written.clone())?;
                members.push((name.to_owned(), written));
                if self.peek() != "," {
                    break;
                }
                self.at += 1;
            }
            self.expect(";")?;
        }
        self.expect("}")?;
        self.skip_if(";");
        self.structs.insert(full, members);
        Ok(())
    }

    /// A type.
    fn written(&mut self) -> Result<Written, DefinitionError> {
        self.annotations();
        let mut name = self.next().to_owned();
        if name == "sequence" {
            self.expect("<")?;
            let inner = self.written()?;
            self.bound()?;
            return Ok(Written { name: String::new(), many: Many::Sequence, inner: Some(Box::new(inner)) });
        }
        if matches!(name.as_str(), "string" | "wstring") && self.peek() == "<" {
            self.at += 1;
            self.bound()?;
        }
        while matches!(name.as_str(), "unsigned" | "long" | "unsigned long")
            && matches!(self.peek(), "long" | "short" | "double")
        {
            name = format!("{name} {}", self.next());
        }
        while self.peek() == "::" {
            self.at += 1;
            name = format!("{name}::{}", self.next());
        }
        Ok(Written { name, many: Many::One, inner: None })
    }

    /// The bound of a type between `<` and `>`.
    fn bound(&mut self) -> Result<(), DefinitionError> {
        while !matches!(self.peek(), ">" | "") {
            self.at += 1;
        }
        self.expect(">")
    }

    /// The name of a member, with its dimensions.
    fn declarator(&mut self, written: Written) -> Result<(&'a str, Written), DefinitionError> {
        let name = self.next();
        let mut count = 1_usize;
        let mut has_dimensions = false;
        while self.peek() == "[" {
            self.at += 1;
            let size = self.next();
            let size: usize = size
                .parse()
                .map_err(|_| DefinitionError(format!("IDL: `{size}` is not a size of `{name}`")))?;
            count = count.saturating_mul(size);
            has_dimensions = true;
            self.expect("]")?;
        }
        if !has_dimensions {
            return Ok((name, written));
        }
        Ok((name, Written { name: String::new(), many: Many::Fixed(count), inner: Some(Box::new(written)) }))
    }

    /// The field of a member; a structure without a name represents items that are lists themselves.
    fn resolve(
        &self,
        own: &str,
        member: &str,
        written: &Written,
        structs: &mut Vec<Struct>,
        depth: usize,
    ) -> Result<Field, DefinitionError> {
        if depth > MOST_DEEP {
            return Err(DefinitionError(format!("IDL: the type of `{member}` has no end")));
        }
        let name = member.to_owned();
        if let Some(inner) = &written.inner {
            let item = self.resolve(own, "", inner, structs, depth + 1)?;
            if item.many == Many::One {
                return Ok(Field { name, base: item.base, many: written.many });
            }
            structs.push(Struct { name: String::new(), fields: vec![item] });
            return Ok(Field { name, base: Base::Struct(structs.len() - 1), many: written.many });
        }
        let base = match written.name.as_str() {
            "boolean" => Base::Bool,
            "octet" | "uint8" | "char" => Base::U8,
            "int8" => Base::I8,
            "unsigned short" | "uint16" => Base::U16,
            "short" | "int16" => Base::I16,
            "unsigned long" | "uint32" => Base::U32,
            "long" | "int32" => Base::I32,
            "unsigned long long" | "uint64" => Base::U64,
            "long long" | "int64" => Base::I64,
            "float" => Base::F32,
            "double" => Base::F64,
            "string" => Base::Text,
            other => return self.resolve_named(own, member, other, structs, depth),
        };
        Ok(Field { name, base, many: Many::One })
    }

    fn resolve_named(
        &self,
        own: &str,
        member: &str,
        other: &str,
        structs: &mut Vec<Struct>,
        depth: usize,
    ) -> Result<Field, DefinitionError> {
        let scope: Vec<&str> = own.split("::").collect();
        let names = (0..scope.len()).rev().map(|n| {
            let mut parts = scope[..n].to_vec();
            parts.push(other);
            parts.join("::")
        });
        for full in names {
            if let Some(i) = self.structs.get_index_of(&full) {
                return Ok(Field { name: member.into(), base: Base::Struct(i), many: Many::One });
            }
            if let Some(written) = self.types.get(&full) {
                return self.resolve(&full, member, written, structs, depth + 1);
            }
        }
        Err(DefinitionError(format!("the definition of `{other}` is missing, which {own} holds")))
    }
}

/// Splits a text into words, marks and literals; skips comments, includes and separator lines.
fn tokens(text: &str) -> Vec<&str> {
    let mut found = Vec::new();
    let mut rest = text;
    loop {
        rest = rest.trim_start();
        let Some(first) = rest.chars().next() else { return found };
        let is_word = |c: char| c.is_alphanumeric() || matches!(c, '_' | '.');
        let length =
            if rest.starts_with("//") || first == '#' || rest.starts_with("====") || rest.starts_with("IDL:")
            {
                rest = &rest[rest.find('\n').unwrap_or(rest.len())..];
                continue;
            } else if rest.starts_with("/*") {
                rest = rest.find("*/").map_or("", |end| &rest[end + 2..]);
                continue;
            } else if first == '"' || first == '\'' {
                literal(rest, first)
            } else if rest.starts_with("::") {
                2
            } else if is_word(first) {
                rest.find(|c| !is_word(c)).unwrap_or(rest.len())
            } else {
                first.len_utf8()
            };
        found.push(&rest[..length]);
        rest = &rest[length..];
    }
}

/// Length of a literal with its marks.
fn literal(text: &str, mark: char) -> usize {
    let mut is_escaped = false;
    for (at, c) in text.char_indices().skip(1) {
        match c {
            _ if is_escaped => is_escaped = false,
            '\\' => is_escaped = true,
            _ if c == mark => return at + c.len_utf8(),
            _ => {}
        }
    }
    text.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"
================================================================================
IDL: demo/msg/Whole
// generated
#include "demo/msg/Other.idl"
module demo { module msg {
  typedef double double__3[3];
  typedef double__3 grid[2];
  module Whole_Constants { const uint8 A = 1; };
  @verbatim (language="comment", text="a ) and \"b\"" "c")
  struct Whole {
    demo::msg::Other other;
    @default (value=1.5) double x;
    sequence<string<10>, 4> names;
    double__3 axis;
    sequence<grid> grids;
    unsigned long long big, bigger;
  };
}; };
================================================================================
IDL: demo/msg/Other
module demo { module msg { struct Other { sequence<long> values; }; }; };
"#;

    #[test]
    fn truth_what_ros_writes_is_read() {
        let found = parse("demo/msg/Whole", TEXT).expect("a definition");
        let root = &found.structs[found.root];
        let shown: Vec<_> = root.fields.iter().map(|f| (f.name.as_str(), f.base, f.many)).collect();
        assert_eq!(shown[0], ("other", Base::Struct(1), Many::One));
        assert_eq!(shown[1], ("x", Base::F64, Many::One));
        assert_eq!(shown[2], ("names", Base::Text, Many::Sequence));
        assert_eq!(shown[3], ("axis", Base::F64, Many::Fixed(3)));
        assert_eq!(shown[5..], [("big", Base::U64, Many::One), ("bigger", Base::U64, Many::One)]);
        // A sequence of two arrays of three numbers: structures without a name represent the arrays.
        let Base::Struct(grid) = shown[4].1 else { panic!("{shown:?}") };
        assert_eq!(found.structs[grid].fields[0].many, Many::Fixed(2));
        assert!(parse("demo/msg/None", TEXT).expect_err("missing").0.contains("demo/None"));
    }

    #[test]
    fn prop_cut_texts_end_with_an_error_or_a_definition() {
        for end in (0..TEXT.len()).filter(|end| TEXT.is_char_boundary(*end)) {
            drop(parse("demo/msg/Whole", &TEXT[..end]));
        }
        assert!(parse("a/B", "module a { typedef X X; struct B { X x; }; };").is_err());
    }
}
