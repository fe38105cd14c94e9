//! `feeler new`.

use std::fmt::Write as _;
use std::fs::{OpenOptions, create_dir_all};
use std::io::{ErrorKind, Write};
use std::path::Path;

use feeler_arm::{JointKind, Urdf};
use feeler_engine::{Program, Simulation, Trace};
use feeler_files::{ARM_TEMPLATE, Document, FOLDERS, Folder, TEMPLATES, template};
use feeler_problem::Remedy;

use crate::arguments::New;
use crate::terminal;
use crate::terminal::failure::BadInput;
use crate::terminal::table;

/// The scenario whose runs are the records of the dataset's template, and their number.
const MEASURED: (&str, u64) = ("bench.toml", 4);

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
        "an editor that knows TOML completes its keys after: feeler schema {kind} > {kind}.schema.json"
    ));
}

/// Writes the files of a folder; those of a dataset include the records of its bench.
fn write_folder(folder: &Folder, out: Option<&Path>) -> crate::Result<()> {
    let Some(out) = out else {
        let message = format!("the template `{}` is a folder of several files", folder.name);
        return Err(BadInput::error(message, "name the folder with --out DIR"));
    };
    create_dir_all(out).map_err(|error| BadInput::unwritable(out, &error))?;
    for (name, text) in folder.files {
        write_new(&out.join(name), text)?;
    }
    if folder.files.iter().any(|(name, _)| *name == MEASURED.0) {
        for k in 1..=MEASURED.1 {
            write_new(&out.join(format!("sines-{k}.csv")), &record(&out.join(MEASURED.0), k)?)?;
        }
    }
    let (first, out) = (out.join(folder.files[0].0), out.display());
    let next =
        if folder.name == "sweep" { format!("sweep {}", first.display()) } else { format!("diagnose {out}") };
    terminal::complain(&format!("wrote {out}; go on with: feeler {next}"));
    complete_keys(folder.name);
    Ok(())
}

/// The record of a scenario with this seed, as a CSV file.
fn record(scenario: &Path, seed: u64) -> crate::Result<String> {
    let mut scenario = Document::load(scenario)?.scenario;
    scenario.run.seed = seed;
    let program = Program::new(&scenario)?;
    let mut trace = Trace::new(program.record_names());
    Simulation::<f64>::new(vec![program])?.run(&mut trace)?;
    let mut text = String::from("t_s,target_rad,encoder_rad\n");
    let columns = scenario.run.record.iter().filter_map(|signal| trace.column(&signal.to_string()));
    let columns: Vec<&[f64]> = columns.collect();
    for (row, t_s) in trace.t_s.iter().enumerate() {
        let _ = write!(text, "{t_s:.3}");
        for column in &columns {
            let _ = write!(text, ",{:.6}", column[row]);
        }
        text.push('\n');
    }
    Ok(text)
}

/// An arm file for the joints of a URDF, with numbers of typical size.
fn arm_file(path: &Path, out: Option<&Path>) -> crate::Result<String> {
    let wrong =
        |message: String, remedy: &str| BadInput::error(format!("{}: {message}", path.display()), remedy);
    let text = std::fs::read_to_string(path)
        .map_err(|error| wrong(error.to_string(), "name the URDF of the robot with --urdf FILE"))?;
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
    let mut text = format!(
        "# The drives of an arm, which its URDF does not state. Numbers are those of gears of that size;\n\
         # put those of your drives in their place.\n\
         name = {:?}\nurdf = {:?}\ntool = {tool:?}\n",
        chain.name,
        named.display().to_string()
    );
    for joint in &chain.joints {
        let effort = joint.effort_limit.unwrap_or(50.0);
        let (stiffness, unit) =
            (200.0 * effort, if joint.kind == JointKind::Prismatic { "kg" } else { "kg m2" });
        let _ = write!(
            text,
            "\n[joints.{:?}]\ngear_ratio    = 100\nrotor_inertia = \"{:e} {unit}\"\n\
             stiffness     = {stiffness}\n\
             damping       = {}\nviscous_friction = {}\ndry_friction     = {}\n",
            joint.name,
            1e-6 * effort,
            1e-3 * stiffness,
            joint.viscous_friction,
            joint.dry_friction
        );
    }
    Ok(text)
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
