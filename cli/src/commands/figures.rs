//! `feeler figures`.

use std::fmt::Write as _;

use feeler_validation::figures::figures;

use crate::arguments::Figures;
use crate::terminal;

pub(crate) fn run(arguments: &Figures) -> crate::Result<()> {
    terminal::make_folder(&arguments.out)?;
    let mut captions = String::from("# The paper's figures, from the reference axis\n");
    let mut files = Vec::new();
    for figure in figures()? {
        let _ = write!(captions, "\n![{0}]({0}.svg)\n\n{1}\n", figure.name, figure.caption);
        files.push((format!("{}.svg", figure.name), figure.svg()));
    }
    files.push(("captions.md".into(), captions));
    terminal::print(terminal::write_all(&arguments.out, &files)?.trim_start())
}
