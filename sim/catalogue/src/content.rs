//! The content of keys.

/// Content of one key, SI.
#[derive(Clone, Debug, PartialEq)]
pub enum Content {
    /// A quantity.
    Number(f64),
    Count(u64),
    Flag(bool),
    /// A text, the name of an element or of a signal.
    Text(String),
    Texts(Vec<String>),
    /// One of the key's words.
    Word(&'static str),
    /// The names of two bodies.
    Pair([String; 2]),
    /// Low and high end.
    Range([f64; 2]),
    /// A list of quantities.
    Numbers(Vec<f64>),
    /// Times (s) and values.
    Points(Vec<(f64, f64)>),
    Table(Contents),
}

/// Contents of the keys of a table. A key without content is absent or had a mistake.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contents {
    /// The word of the shape's choice.
    pub variant: Option<&'static str>,
    entries: Vec<(&'static str, Content)>,
}

impl Contents {
    /// A table without keys.
    pub fn new(variant: Option<&'static str>) -> Self {
        Self { variant, entries: Vec::new() }
    }

    /// Adds the content of a key.
    pub fn insert(&mut self, key: &'static str, content: Content) {
        self.entries.push((key, content));
    }

    /// Keys and contents, in the order of the shape.
    pub fn iter(&self) -> impl Iterator<Item = &(&'static str, Content)> {
        self.entries.iter()
    }

    /// Content of a key.
    pub fn get(&self, key: &str) -> Option<&Content> {
        self.entries.iter().find(|(name, _)| *name == key).map(|(_, content)| content)
    }
}
