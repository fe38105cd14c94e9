//! What keys hold.

/// What one key holds, SI.
#[derive(Clone, Debug, PartialEq)]
pub enum Content {
    /// A quantity.
    Number(f64),
    /// A whole number.
    Count(u64),
    /// True or false.
    Flag(bool),
    /// A text, the name of an element or of a signal.
    Text(String),
    /// Texts.
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
    /// A table.
    Table(Contents),
}

/// What the keys of a table hold. A key without content stands for nothing, or was wrong.
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

    /// Adds what a key holds.
    pub fn insert(&mut self, key: &'static str, content: Content) {
        self.entries.push((key, content));
    }

    /// Keys and what they hold, in the order of the shape.
    pub fn iter(&self) -> impl Iterator<Item = &(&'static str, Content)> {
        self.entries.iter()
    }

    /// What a key holds.
    pub fn get(&self, key: &str) -> Option<&Content> {
        self.entries.iter().find(|(name, _)| *name == key).map(|(_, content)| content)
    }

    /// A quantity. One that was wrong gives a harmless stand-in: the file as a whole is refused then, and
    /// nothing sees it.
    pub fn number(&self, key: &str) -> f64 {
        self.optional(key).unwrap_or(1.0)
    }

    /// A quantity that may be absent.
    pub fn optional(&self, key: &str) -> Option<f64> {
        if let Some(Content::Number(value)) = self.get(key) { Some(*value) } else { None }
    }

    /// A whole number.
    pub fn count(&self, key: &str) -> Option<u64> {
        if let Some(Content::Count(value)) = self.get(key) { Some(*value) } else { None }
    }

    /// Whether a flag is set.
    pub fn flag(&self, key: &str) -> bool {
        matches!(self.get(key), Some(Content::Flag(true)))
    }

    /// A text or word.
    pub fn text(&self, key: &str) -> Option<&str> {
        match self.get(key) {
            Some(Content::Text(text)) => Some(text),
            Some(Content::Word(word)) => Some(word),
            _ => None,
        }
    }

    /// The names of two bodies.
    pub fn pair(&self, key: &str) -> [String; 2] {
        if let Some(Content::Pair(pair)) = self.get(key) { pair.clone() } else { Default::default() }
    }

    /// A table.
    pub fn table(&self, key: &str) -> Option<&Self> {
        if let Some(Content::Table(contents)) = self.get(key) { Some(contents) } else { None }
    }

    /// Two quantities, low and high.
    pub fn range(&self, key: &str) -> Option<[f64; 2]> {
        if let Some(Content::Range(range)) = self.get(key) { Some(*range) } else { None }
    }

    /// A list of quantities.
    pub fn numbers(&self, key: &str) -> Option<&[f64]> {
        if let Some(Content::Numbers(numbers)) = self.get(key) { Some(numbers) } else { None }
    }

    /// Times (s) and values.
    pub fn points(&self, key: &str) -> Vec<(f64, f64)> {
        if let Some(Content::Points(points)) = self.get(key) { points.clone() } else { Vec::new() }
    }
}
