//! Threads for computations without their own threads.

use feeler_analysis::Workers;
use rayon::prelude::*;

/// All processors.
pub const ALL_PROCESSORS: Workers = Workers::new(|count, task| (0..count).into_par_iter().for_each(task));
