//! No file of a crate may depend on itself through other files: such files can only be read and changed
//! together.
//!
//! The test counts paths in code (not in comments, tests or re-exports) that begin with `crate::`, `super::`
//! or `self::`. It also counts those that begin with a module of the same file. A name that the root takes
//! from a module leads to that module.

#![expect(clippy::unwrap_used, reason = "a test of files that must be there")]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The known circle. It stays because an element holds its effects, and an effect is defined by the change
/// that it makes to an assembly. The assembly keeps what elements state: engagement, filter, profile.
const KNOWN: [&str; 4] = [
    "sim/plant/src/assembly/mod.rs",
    "sim/plant/src/description/mod.rs",
    "sim/plant/src/effects/mod.rs",
    "sim/plant/src/effects/definition.rs",
];

/// A module's path within its crate.
type Module = Vec<String>;

/// Paths within a crate, and the modules to which they lead.
type Modules = BTreeMap<Module, Module>;

#[test]
fn truth_files_of_a_crate_need_each_other_one_way_only() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut found = BTreeSet::new();
    for source in sources(root) {
        let files = files(&source);
        assert!(files.contains_key(&Vec::new()), "{} has no root", source.display());
        let name = |module: &Module| files[module].strip_prefix(root).unwrap().display().to_string();
        for circle in circles(&needs(&files)) {
            found.insert(circle.iter().map(name).collect::<Vec<_>>());
        }
    }
    assert!(
        found.remove(KNOWN.map(str::to_owned).as_slice()),
        "the known circle no longer exists: {found:#?}"
    );
    assert!(found.is_empty(), "files that need each other; part what both need from the rest: {found:#?}");
}

#[test]
fn truth_a_circle_through_a_group_a_parent_and_a_child_is_seen() {
    let needs = |text: &str, module: &[&str]| {
        let all = [vec![], vec!["a"], vec!["a", "b"], vec!["c"]];
        let path = |path: &Vec<&str>| path.iter().map(ToString::to_string).collect::<Module>();
        let mut all: Modules = all.iter().map(|own| (path(own), path(own))).collect();
        all.extend(at_root("mod a;\nuse other::Y;\npub use a::b::{X, Z};"));
        let module: Module = module.iter().map(ToString::to_string).collect();
        paths(&code(text), &module, &all).iter().map(|module| module.join("::")).collect::<Vec<_>>()
    };
    assert_eq!(needs("use crate::{a::{b::X, Y}, c};", &["d"]), ["a", "a::b", "c"]);
    assert_eq!(needs("fn f(x: super::Y) -> super::super::c::Z {}", &["a", "b"]), ["a", "c"]);
    assert_eq!(needs("mod b;\nfn f() { b::go() }", &["a"]), ["a::b"]);
    assert_eq!(needs("use crate::X;", &["c"]), ["a::b"]);
    assert_eq!(
        needs("mod b;\npub use b::X;\n// crate::c\n#[cfg(test)]\nmod tests {\nuse crate::c;\n}", &["a"]),
        [""; 0]
    );
}

/// The source folders of all crates.
fn sources(root: &Path) -> Vec<PathBuf> {
    let folders = |path: &Path| -> Vec<PathBuf> {
        fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path()).filter(|path| path.is_dir()).collect()
    };
    let mut all: Vec<PathBuf> = folders(root);
    all.extend(folders(&root.join("sim")));
    all.retain(|folder| folder.join("Cargo.toml").is_file());
    all.into_iter().map(|folder| folder.join("src")).filter(|source| source.is_dir()).collect()
}

/// Every file below a source folder, by its module.
fn files(source: &Path) -> BTreeMap<Module, PathBuf> {
    let mut files = BTreeMap::new();
    let mut folders = vec![(source.to_path_buf(), Module::new())];
    while let Some((folder, module)) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            let stem = path.file_stem().unwrap().to_str().unwrap().to_owned();
            let inner: Module = module.iter().cloned().chain([stem.clone()]).collect();
            if path.is_dir() {
                folders.push((path, inner));
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let is_own = matches!(stem.as_str(), "mod" | "lib" | "main");
                files.insert(if is_own { module.clone() } else { inner }, path);
            }
        }
    }
    files
}

/// Which modules each module needs.
fn needs(files: &BTreeMap<Module, PathBuf>) -> BTreeMap<Module, BTreeSet<Module>> {
    let text = |path: &PathBuf| fs::read_to_string(path).unwrap();
    let names = at_root(&text(&files[&Module::new()]));
    let all: Modules = files.keys().cloned().map(|module| (module.clone(), module)).chain(names).collect();
    let of = |(module, path): (&Module, &PathBuf)| {
        let mut found = paths(&code(&text(path)), module, &all);
        found.retain(|module| files.contains_key(module));
        (module.clone(), found)
    };
    files.iter().map(of).collect()
}

/// The names that a root takes from modules and other crates, each with its place. A path through the root
/// leads there.
fn at_root(text: &str) -> Modules {
    let mut found = Modules::new();
    let plain = text.lines().map(|line| line.split("//").next().unwrap_or_default());
    let text = plain.collect::<Vec<_>>().join("\n");
    for statement in text.split(';').filter_map(|statement| Some(statement.split_once("use ")?.1)) {
        let words = words(statement);
        let Some(end) = (1..words.len()).step_by(2).take_while(|at| words[*at] == "::").last() else {
            continue;
        };
        let path: Module = words[..end].iter().step_by(2).map(ToString::to_string).collect();
        let names = words[end + 1..].iter().filter(|word| word.starts_with(char::is_alphabetic));
        found.extend(names.map(|name| (vec![(*name).to_owned()], path.clone())));
    }
    found
}

/// A file without comments, its module of tests, and re-exports.
fn code(text: &str) -> String {
    let text = text.find("#[cfg(test)]\nmod tests {").map_or(text, |tests| &text[..tests]);
    let lines = text.lines().map(|line| line.split("//").next().unwrap_or_default());
    let text = lines.collect::<Vec<_>>().join("\n");
    let is_export = |statement: &&str| {
        let statement = statement.trim_start();
        statement.starts_with("pub")
            && statement.split_once("use ").is_some_and(|(before, _)| !before.contains('{'))
    };
    let text: String = text.split_inclusive(';').filter(|statement| !is_export(statement)).collect();
    // Visibility of an item is not a dependency.
    let mut parts = text.split("pub(in ");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |code, part| code + part.split_once(')').map_or(part, |(_, rest)| rest))
}

/// Modules other than `module` that paths in its code lead to.
fn paths(code: &str, module: &Module, all: &Modules) -> BTreeSet<Module> {
    let words = words(code);
    let mut found = BTreeSet::new();
    for at in 0..words.len().saturating_sub(1) {
        // A macro names what it needs where it is used.
        let is_first = at == 0 || !["::", "$"].contains(&words[at - 1]);
        if !is_first || words[at + 1] != "::" {
            continue;
        }
        let child: Module = module.iter().cloned().chain([words[at].to_owned()]).collect();
        if matches!(words[at], "crate" | "super" | "self") || all.contains_key(&child) {
            follow(&words, at, module.clone(), all, &mut found);
        }
    }
    found.remove(module);
    found
}

/// Follows the path that begins at word `at`, from `base`; returns its end.
fn follow(words: &[&str], mut at: usize, base: Module, all: &Modules, found: &mut BTreeSet<Module>) -> usize {
    let (mut here, mut is_inside) = (base, true);
    loop {
        match words.get(at).copied() {
            Some("crate") => here.clear(),
            Some("super") => {
                here.pop();
            }
            Some("self") | None => {}
            Some("{") => {
                at += 1;
                while words.get(at).is_some_and(|word| *word != "}") {
                    at = follow(words, at, here.clone(), all, found) + 1;
                    at += usize::from(words.get(at) == Some(&","));
                }
                return at;
            }
            Some(word) => {
                here.push(word.to_owned());
                if let Some(module) = all.get(&here).filter(|_| is_inside) {
                    here.clone_from(module);
                } else {
                    here.pop();
                    is_inside = false;
                }
            }
        }
        if words.get(at + 1) != Some(&"::") {
            found.insert(here);
            return at;
        }
        at += 2;
    }
}

/// Names, `::`, and every other character as a separate word.
fn words(code: &str) -> Vec<&str> {
    let mut words = Vec::new();
    let mut rest = code.trim_start();
    while let Some(first) = rest.chars().next() {
        let length = if rest.starts_with("::") {
            2
        } else {
            let name = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
            name.max(first.len_utf8())
        };
        words.push(&rest[..length]);
        rest = rest[length..].trim_start();
    }
    words
}

/// Modules that can be reached from each other, two or more together.
fn circles(needs: &BTreeMap<Module, BTreeSet<Module>>) -> BTreeSet<Vec<Module>> {
    let reached: BTreeMap<&Module, BTreeSet<&Module>> = needs
        .keys()
        .map(|from| {
            let mut reached = BTreeSet::new();
            let mut open = vec![from];
            while let Some(module) = open.pop() {
                open.extend(needs[module].iter().filter(|next| reached.insert(*next)));
            }
            (from, reached)
        })
        .collect();
    let circle = |module: &&Module| -> Vec<Module> {
        let is_both =
            |other: &&&Module| reached[module].contains(**other) && reached[**other].contains(*module);
        reached.keys().filter(is_both).map(|other| (*other).clone()).collect()
    };
    reached.keys().map(circle).filter(|circle| circle.len() > 1).collect()
}
