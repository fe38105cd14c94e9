//! Writes the macro `effects!`: the files of `src/effects/` that define an effect, in the order of the
//! manual. So a new effect is a new file, without a list beside the folder.

use std::error::Error;
use std::ffi::OsStr;
use std::path::Path;
use std::{env, fs};

const FOLDER: &str = "src/effects";

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed={FOLDER}");
    // Two copies of this tree may share a build folder; both write the same list. The full path makes the
    // next build of the other copy run this script again.
    println!(
        "cargo::rerun-if-changed={}",
        Path::new(&env::var("CARGO_MANIFEST_DIR")?).join(FOLDER).display()
    );
    let mut effects = Vec::new();
    for entry in fs::read_dir(FOLDER)? {
        let path = entry?.path();
        let (Some(file), Some("rs")) =
            (path.file_stem().and_then(OsStr::to_str), path.extension().and_then(OsStr::to_str))
        else {
            continue;
        };
        let text = fs::read_to_string(&path)?;
        let Some((_, definition)) = text.split_once("static DEFINITION: Definition = ") else { continue };
        let order = definition.lines().find_map(|line| line.strip_prefix("    order: ")?.strip_suffix(','));
        let order: u16 = order
            .and_then(|order| order.parse().ok())
            .ok_or_else(|| format!("{}: `DEFINITION` needs a line such as `order: 45,`", path.display()))?;
        effects.push((order, format!("            {file} {},", kind(file))));
    }
    effects.sort();
    let list: Vec<String> = effects.into_iter().map(|(_, line)| line).collect();
    let text = format!(
        "/// Passes every effect, in the order of the manual, to a macro: `file Kind,` each.
#[macro_export]
macro_rules! effects {{
    ($to:ident) => {{
        $to! {{
{}
        }}
    }};
}}
",
        list.join("\n")
    );
    fs::write(Path::new(&env::var("OUT_DIR")?).join("effects.rs"), text)?;
    Ok(())
}

/// The kind that a file defines: `command_delay` has `CommandDelay`.
fn kind(file: &str) -> String {
    file.split('_').map(|word| word[..1].to_uppercase() + &word[1..]).collect()
}
