//! `feeler new`.

use std::fs::OpenOptions;
use std::io::{ErrorKind, Write};
use std::path::Path;

use feeler_arm::Urdf;
use feeler_files::{ARM_TEMPLATE, Document, FOLDERS, Folder, TEMPLATES, arm_text, template};
use feeler_problem::Remedy;
use feeler_problem::sort::sort_of;
use feeler_studies::run::record_csv;

use crate::arguments::New;
use crate::terminal;
use crate::terminal::failure::BadInput;
use crate::terminal::table;

/// The scenario whose runs are the records of the dataset's template, their number, and their columns.
const MEASURED: (&str, u64, [&str; 2]) = ("bench.toml", 4, ["target_rad", "encoder_rad"]);

pub(crate) fn run(arguments: &New) -> crate::Result<()> {
    let name = arguments.template.as_deref().unwrap_or_default();
    if let (true, Some(urdf)) = (name == ARM_TEMPLATE.0, &arguments.urdf) {
        return written(arguments.out.as_deref(), &arm_file(urdf, arguments.out.as_deref())?, "check");
    }
    if let Some(folder) = FOLDERS.iter().find(|folder| folder.name == name) {
        return write_folder(folder, arguments.out.as_deref());
    }
    let Some(found) = template(name) else {
        let single = TEMPLATES.iter().map(|template| (template.name, template.about));
        let all =
            single.chain(FOLDERS.iter().map(|folder| (folder.name, folder.about))).chain([ARM_TEMPLATE]);
        let rows = all.map(|(name, about)| vec![name.to_owned(), about.to_owned()]);
        return terminal::print(&table(&["template", "what it is"], &[], rows));
    };
    written(arguments.out.as_deref(), found.text, "run")
}

/// Prints a text, or writes it to a file and names the next command.
fn written(out: Option<&Path>, text: &str, command: &str) -> crate::Result<()> {
    let Some(path) = out else { return terminal::print(text) };
    write_new(path, text)?;
    let path = path.display();
    terminal::complain(&format!("wrote {path}; {command} it with: feeler {command} {path}"));
    if command == "run" {
        complete_keys("machine");
    }
    Ok(())
}

/// Tells how an editor learns the keys of a kind of file.
fn complete_keys(kind: &str) {
    terminal::complain(&format!(
        "for completion of keys in a TOML editor: feeler schema {kind} > {kind}.schema.json"
    ));
}

/// Writes the files of a folder; those of a dataset include the records of its bench.
fn write_folder(folder: &Folder, out: Option<&Path>) -> crate::Result<()> {
    let Some(out) = out else {
        let message = format!("the template `{}` is a folder of several files", folder.name);
        return Err(BadInput::error(message, "name the folder with --out DIR"));
    };
    terminal::make_folder(out)?;
    for (name, text) in folder.files {
        write_new(&out.join(name), text)?;
    }
    if folder.files.iter().any(|(name, _)| *name == MEASURED.0) {
        let scenario = Document::load(&out.join(MEASURED.0))?.scenario;
        for k in 1..=MEASURED.1 {
            let mut scenario = scenario.clone();
            scenario.run.seed = k;
            write_new(&out.join(format!("sines-{k}.csv")), &record_csv(&scenario, &MEASURED.2)?)?;
        }
    }
    let (first, out) = (out.join(folder.files[0].0), out.display());
    let next =
        if folder.name == "sweep" { format!("sweep {}", first.display()) } else { format!("diagnose {out}") };
    terminal::complain(&format!("wrote {out}; go on with: feeler {next}"));
    complete_keys(folder.name);
    Ok(())
}

/// An arm file for the joints of a URDF, with numbers of typical size.
fn arm_file(path: &Path, out: Option<&Path>) -> crate::Result<String> {
    let wrong =
        |message: String, remedy: &str| BadInput::error(format!("{}: {message}", path.display()), remedy);
    let remedy = "name the URDF of the robot with --urdf FILE";
    let bytes = std::fs::read(path).map_err(|error| wrong(error.to_string(), remedy))?;
    let text = String::from_utf8(bytes).map_err(|error| {
        let sort = sort_of(error.as_bytes());
        wrong(sort.map_or("this is not text", |sort| sort.what).into(), remedy)
    })?;
    let urdf = Urdf::parse(&text).map_err(|error| wrong(error.to_string(), &error.remedy()))?;
    let tool = urdf.last_link().unwrap_or_default();
    let chain = urdf.chain(tool).map_err(|error| wrong(error.to_string(), &error.remedy()))?;
    // The name of the URDF is relative to the arm file.
    let beside = out.and_then(Path::parent).is_none_or(|folder| path.parent() == Some(folder));
    let named = if beside {
        path.file_name().map_or(path, Path::new).to_path_buf()
    } else {
        std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf())
    };
    Ok(arm_text(&chain, tool, &named))
}

/// Writes a file that must not exist yet.
fn write_new(path: &Path, text: &str) -> crate::Result<()> {
    let write = || OpenOptions::new().write(true).create_new(true).open(path)?.write_all(text.as_bytes());
    write().map_err(|error| match error.kind() {
        ErrorKind::AlreadyExists => BadInput::error(
            format!("{} exists already, and is not overwritten", path.display()),
            "name another file with --out, or delete it",
        ),
        _ => BadInput::unwritable(path, &error),
    })
}
