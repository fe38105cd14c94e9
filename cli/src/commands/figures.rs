//! `feeler figures`.

use std::fmt::Write as _;
use std::fs;

use feeler_validation::figures::figures;

use crate::arguments::Figures;
use crate::terminal;
use crate::terminal::failure::BadInput;

pub(crate) fn run(arguments: &Figures) -> crate::Result<()> {
    let folder = &arguments.out;
    fs::create_dir_all(folder).map_err(|error| BadInput::unwritable(folder, &error))?;
    let mut captions = String::from("# The paper's figures, from the reference axis\n");
    let mut written = Vec::new();
    for figure in figures()? {
        let path = folder.join(format!("{}.svg", figure.name));
        fs::write(&path, figure.svg()).map_err(|error| BadInput::unwritable(&path, &error))?;
        let _ = write!(captions, "\n![{0}]({0}.svg)\n\n{1}\n", figure.name, figure.caption);
        written.push(format!("  {}", path.display()));
    }
    let path = folder.join("captions.md");
    fs::write(&path, captions).map_err(|error| BadInput::unwritable(&path, &error))?;
    terminal::print(&format!("wrote\n{}\n  {}", written.join("\n"), path.display()))
}
