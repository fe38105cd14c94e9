//! A path for each number of a message, as in `position[elbow]` or `points[0].velocities[1]`.
//!
//! If a message lists names (`name` of a joint state, `joint_names` of a trajectory), these name the items of
//! other lists of that length.

use super::cdr::{LONGEST_LIST, Numbers, names_items};
use super::definition::{Base, Definition, Many};

/// The layout of a message, without its numbers.
enum Node {
    Number,
    Text,
    Names(Vec<String>),
    LeftOut(usize),
    Array(Vec<Node>),
    Sequence(Vec<Node>),
    Struct(Vec<(String, Node)>),
}

/// Paths of the numbers of a message, and the omitted fields.
pub(super) fn paths(definition: &Definition, numbers: &Numbers) -> (Vec<String>, Vec<String>) {
    let names = String::from_utf8_lossy(&numbers.names).into_owned();
    let mut layout =
        Layout { definition, lengths: numbers.lengths.iter().copied(), names: names.split('\0') };
    let root = layout.structure(definition.root);
    let mut labels = Labels::default();
    labels.visit(&root, "", &mut Vec::new());
    (labels.paths, labels.left_out)
}

struct Layout<'a, L, N> {
    definition: &'a Definition,
    lengths: L,
    names: N,
}

impl<'a, L: Iterator<Item = u32>, N: Iterator<Item = &'a str>> Layout<'a, L, N> {
    fn structure(&mut self, index: usize) -> Node {
        let definition = self.definition;
        let mut members = Vec::new();
        for field in &definition.structs[index].fields {
            let count = match field.many {
                Many::One => 1,
                Many::Fixed(count) => count,
                Many::Sequence => self.lengths.next().unwrap_or(0) as usize,
            };
            let is_number = !matches!(field.base, Base::Struct(_) | Base::Text);
            let node = if is_number && count > LONGEST_LIST {
                Node::LeftOut(count)
            } else if field.base == Base::Text && field.many != Many::One && names_items(&field.name) {
                Node::Names((0..count).map(|_| self.names.next().unwrap_or_default().to_owned()).collect())
            } else {
                let mut item = || match field.base {
                    Base::Struct(inner) => self.structure(inner),
                    Base::Text => Node::Text,
                    _ => Node::Number,
                };
                match field.many {
                    Many::One => item(),
                    Many::Fixed(_) => Node::Array((0..count).map(|_| item()).collect()),
                    Many::Sequence => Node::Sequence((0..count).map(|_| item()).collect()),
                }
            };
            members.push((field.name.clone(), node));
        }
        Node::Struct(members)
    }
}

#[derive(Default)]
struct Labels {
    paths: Vec<String>,
    left_out: Vec<String>,
}

impl Labels {
    fn visit<'n>(&mut self, node: &'n Node, path: &str, names: &mut Vec<&'n [String]>) {
        match node {
            Node::Number => self.paths.push(path.to_owned()),
            Node::Text | Node::Names(_) => {}
            Node::LeftOut(count) => self.left_out.push(format!("{path} ({count} numbers a message)")),
            Node::Array(items) => self.items(items, path, None, names),
            Node::Sequence(items) => {
                let own = names.iter().rev().copied().find(|list| {
                    list.len() == items.len() && !items.iter().any(|item| holds_list(item, list.len()))
                });
                self.items(items, path, own, names);
            }
            Node::Struct(members) => {
                let before = names.len();
                names.extend(members.iter().filter_map(|(_, node)| match node {
                    Node::Names(list) if !list.is_empty() => Some(list.as_slice()),
                    _ => None,
                }));
                for (name, node) in members {
                    let inner = match (path.is_empty(), name.is_empty()) {
                        (true, _) => name.clone(),
                        (_, true) => path.to_owned(),
                        _ => format!("{path}.{name}"),
                    };
                    self.visit(node, &inner, names);
                }
                names.truncate(before);
            }
        }
    }

    fn items<'n>(
        &mut self,
        items: &'n [Node],
        path: &str,
        own: Option<&[String]>,
        names: &mut Vec<&'n [String]>,
    ) {
        for (i, item) in items.iter().enumerate() {
            let inner = match own {
                Some(own) => format!("{path}[{}]", own[i]),
                None => format!("{path}[{i}]"),
            };
            self.visit(item, &inner, names);
        }
    }
}

/// Whether a structure contains a list of numbers of this length, to which a list of names then belongs. A
/// structure with names of its own needs none from outside.
fn holds_list(node: &Node, length: usize) -> bool {
    match node {
        Node::Struct(members) if members.iter().any(|(_, node)| matches!(node, Node::Names(_))) => false,
        Node::Struct(members) => members.iter().any(|(_, node)| match node {
            Node::Sequence(items) => {
                items.len() == length || items.iter().any(|item| holds_list(item, length))
            }
            other => holds_list(other, length),
        }),
        _ => false,
    }
}
