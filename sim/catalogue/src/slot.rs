//! Types of a single key.

use crate::content::{Content, Contents};
use crate::field::Keyed;
use crate::shape::Key;

/// A type that one key fills.
pub trait Slot: Sized {
    /// Its content; `None` if absent.
    fn content(&self) -> Option<Content>;
    /// The value of a content; `None` for content that the file reader rejects.
    fn of(content: &Content) -> Option<Self>;
}

macro_rules! slots {
    ($($slot:ty: $form:ident;)*) => { $(
        impl Slot for $slot {
            fn content(&self) -> Option<Content> {
                Some(Content::$form(Clone::clone(self)))
            }

            fn of(content: &Content) -> Option<Self> {
                if let Content::$form(value) = content { Some(Clone::clone(value)) } else { None }
            }
        }
    )* };
}

slots! {
    f64: Number;
    u64: Count;
    bool: Flag;
    [String; 2]: Pair;
    [f64; 2]: Range;
    Vec<f64>: Numbers;
    Vec<(f64, f64)>: Points;
}

impl Slot for u32 {
    fn content(&self) -> Option<Content> {
        Some(Content::Count((*self).into()))
    }

    fn of(content: &Content) -> Option<Self> {
        u64::of(content)?.try_into().ok()
    }
}

impl Slot for usize {
    fn content(&self) -> Option<Content> {
        Some(Content::Count(*self as u64))
    }

    fn of(content: &Content) -> Option<Self> {
        u64::of(content)?.try_into().ok()
    }
}

impl Slot for [f64; 3] {
    fn content(&self) -> Option<Content> {
        Some(Content::Numbers(self.to_vec()))
    }

    fn of(content: &Content) -> Option<Self> {
        Vec::<f64>::of(content)?.try_into().ok()
    }
}

/// A name, whose default is one of the key's words.
impl Slot for String {
    fn content(&self) -> Option<Content> {
        Some(Content::Text(self.clone()))
    }

    fn of(content: &Content) -> Option<Self> {
        match content {
            Content::Text(text) => Some(text.clone()),
            Content::Word(word) => Some((*word).to_owned()),
            _ => None,
        }
    }
}

impl<T: Slot> Slot for Option<T> {
    fn content(&self) -> Option<Content> {
        self.as_ref().and_then(T::content)
    }

    fn of(content: &Content) -> Option<Self> {
        T::of(content).map(Some)
    }
}

/// A table within a table.
impl<T: Keyed> Slot for T {
    fn content(&self) -> Option<Content> {
        Some(Content::Table(self.contents()))
    }

    fn of(content: &Content) -> Option<Self> {
        if let Content::Table(contents) = content { T::read(contents) } else { None }
    }
}

impl Contents {
    /// The value of a key; `None` if it is absent or had a mistake.
    pub fn value<T: Slot>(&self, key: &Key) -> Option<T> {
        self.get(key.name).and_then(T::of)
    }

    /// The table of a key.
    pub fn table(&self, key: &Key) -> Option<&Self> {
        if let Some(Content::Table(contents)) = self.get(key.name) { Some(contents) } else { None }
    }
}

/// Words in files for the variants of an enum, `words!(Enum { Form = "word", "what it means"; ... })`.
/// Defines `WORDS`, `name` and `named`, and implements [`Slot`].
#[macro_export]
macro_rules! words {
    ($owner:ident { $($form:ident = $name:literal, $text:literal;)+ }) => {
        impl $owner {
            /// Its words in files, and their meanings.
            pub const WORDS: &'static [$crate::Word] = &[$($crate::word($name, $text)),+];

            /// Its word in files.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$form => $name,)+
                }
            }

            /// The variant with this word.
            pub fn named(name: &str) -> Option<Self> {
                match name {
                    $($name => Some(Self::$form),)+
                    _ => None,
                }
            }
        }

        impl $crate::Slot for $owner {
            fn content(&self) -> Option<$crate::Content> {
                Some($crate::Content::Word(self.name()))
            }

            fn of(content: &$crate::Content) -> Option<Self> {
                if let $crate::Content::Word(name) = content { Self::named(name) } else { None }
            }
        }
    };
}
