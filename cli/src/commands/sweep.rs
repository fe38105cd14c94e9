//! `feeler sweep`.

use std::path::Path;
use std::time::Instant;

use feeler_studies::sweep::{self, SweepOptions, SweepResult, Theory};

use super::swept::Swept;
use crate::arguments::Sweep;
use crate::numbers::{count, plain, with_unit};
use crate::pages::sweep::{MOST_PANELS, Tally};
use crate::terminal::progress::Rate;
use crate::terminal::table;
use crate::{pages, terminal};

/// Name of a sweep whose file states none.
const OTHERWISE: &str = "sweep";

pub(crate) fn run(arguments: &Sweep) -> crate::Result<()> {
    let sweep = sweep::Sweep::load(&arguments.file)?;
    let name = name(&sweep, &arguments.file);
    let folder = arguments.out.clone().unwrap_or_else(|| terminal::results::folder(&name, OTHERWISE));
    let rate = Rate::new(name.clone());
    let options = SweepOptions { threads: arguments.threads.map(usize::from), shard: arguments.shard };
    let started = Instant::now();
    let result = sweep.run(&folder, options, &|at| rate.at(at.done, at.found, at.total))?;
    rate.done();
    let wall_s = started.elapsed().as_secs_f64();
    let Some(path) = &result.table else {
        if arguments.json {
            return terminal::print(&terminal::json(&Swept::shard(result.progress.total as usize))?);
        }
        let shard = arguments.shard.map_or_else(String::new, |shard| format!(" of shard {shard}"));
        return terminal::print(&format!(
            "{}{shard} done in {}\nwhen the other shards are done: feeler merge {folder}\nor, if each shard \
             has its own folder: feeler merge {folder} OTHERS... --out FOLDER",
            count(result.progress.total as usize, "variant", "variants"),
            with_unit(wall_s, "s"),
            folder = terminal::quoted_path(&folder)
        ));
    };
    let tally = Tally::of(path)?;
    let shown = pages::sweep::read(&sweep, path, &tally)?;
    let theory = Theory::of(&sweep, &shown.table, MOST_PANELS);
    let (drawn, answer) = pages::sweep::write(&sweep, &name, &shown, &theory, &tally, &folder)?;
    if arguments.json {
        return terminal::print(&terminal::json(&Swept::new(path, tally))?);
    }
    let answer = answer.map_or_else(String::new, |answer| format!("{}\n\n", answer.trim_end()));
    let written: Vec<String> =
        [path].into_iter().chain(&drawn).map(|path| format!("  {}", path.display())).collect();
    terminal::print(&format!(
        "{answer}{}\n\n{}\n\nwrote\n{}",
        finished_text(&sweep, &result, wall_s),
        outcomes(&tally),
        written.join("\n")
    ))
}

/// The name that a sweep file states, or else the name of the file.
fn name(sweep: &sweep::Sweep, file: &Path) -> String {
    let own = if sweep.file.name.is_empty() {
        file.file_stem().unwrap_or_default().to_string_lossy()
    } else {
        (&*sweep.file.name).into()
    };
    terminal::results::safe_name(&own, OTHERWISE)
}

fn finished_text(sweep: &sweep::Sweep, result: &SweepResult, wall_s: f64) -> String {
    let progress = result.progress;
    let variants = count(progress.total as usize, "variant", "variants");
    let text = match (progress.done, progress.found) {
        (0, _) => format!("{variants}, all from an earlier call"),
        (done, 0) => {
            format!("{variants} in {}: {} per second", with_unit(wall_s, "s"), plain(done as f64 / wall_s))
        }
        (done, found) => {
            let rate = plain(done as f64 / wall_s);
            format!(
                "{variants}: {found} from an earlier call, {done} run in {} ({rate} per second)",
                with_unit(wall_s, "s")
            )
        }
    };
    if let Some((grid, edges)) = sweep.runs_of_the_grid().zip(pages::sweep::located(sweep)) {
        let noise = pages::sweep::about_noise(sweep).map_or_else(String::new, |words| format!("\n{words}"));
        let share = plain(100.0 * progress.total as f64 / grid as f64);
        let passes = result
            .passes
            .map_or_else(String::new, |passes| format!(" in {}", count(passes, "pass", "passes")));
        return format!(
            "{text}\nedges located to {edges}{passes}; this took {share} % of the {grid} runs \
             of a full grid{noise}"
        );
    }
    text
}

/// The number of variants with each outcome.
fn outcomes(tally: &Tally) -> String {
    let mut counts: Vec<(&String, &usize)> = tally.outcomes.iter().collect();
    counts.sort_by(|a, b| b.1.cmp(a.1).then(a.0.cmp(b.0)));
    table(&[], &[1], counts.into_iter().map(|(name, number)| vec![name.clone(), number.to_string()]))
}
