//! `feeler live`.

use feeler_diagnosis::dataset::Dataset;
use feeler_files::Document;

use crate::arguments::Live as Arguments;
use crate::live::{Live, Measured, Session};
use crate::terminal;

pub(crate) fn run(arguments: &Arguments) -> crate::Result<()> {
    let measured = match &arguments.data {
        Some(path) => {
            let machine = Document::load(&arguments.file)?.scenario.machine;
            let dataset = Dataset::load_for(path, &machine)?;
            let repaired = arguments.repaired.as_deref().map(Document::load).transpose()?;
            Some(Measured::new(dataset, repaired.map(|document| document.scenario.machine)))
        }
        None => None,
    };
    let session = Session::new(&arguments.file, &arguments.settings, measured)?;
    let live = Live::new(arguments.port)?;
    terminal::print(&live.address())?;
    terminal::complain("open this address in a browser of this computer; Ctrl-C ends it");
    live.serve(&session);
    Ok(())
}
