//! Arguments of `feeler reduce`.

use std::path::PathBuf;

use clap::{ArgGroup, Args, ValueHint};

#[derive(Args, Debug)]
#[command(
    group(ArgGroup::new("place").required(true).args(["pose", "at"])),
    after_help = "Examples:\n  \
    feeler reduce arm.toml --at 0.6,0.1,0.1 --normal 0,0,-1 --out axis.toml\n  \
    feeler analyze axis.toml            linear theory of the arm along that normal\n  \
    feeler reduce arm.toml --pose '0,-40 deg,95 deg' --normal 0,0,-1 --hold\n  \
    feeler reduce arm.toml --at 0.6,0,0 --normal 0,0,-1 --map 0.4,1,6,0,0.4,5\n\n\
    The axis has two masses and a spring. It has the arm's mass, and deflects like the arm under slow \
    forces. If its contact mode or phase crossover is too far from the arm's, further bodies are added \
    beside the motor, or between motor and tool. The printed table compares axis and arm, and warns of \
    differences above 5 %. Gravity counts as compensated.\n\n\
    The force bandwidth is that of the arm under integral control of the contact's spring force, with a \
    gain margin of 2, sampled at 1 kHz. The motor damping is 2 * 0.7 * omega * M. Here omega is the contact \
    mode, and M is the mass of the arm without bending."
)]
pub(crate) struct Reduce {
    /// Arm file (TOML): a URDF and the drives of its joints
    #[arg(value_name = "ARM", value_hint = ValueHint::FilePath)]
    pub(crate) arm: PathBuf,
    /// Joint positions, base first, in rad or as '35 deg' (in m for sliding joints)
    #[arg(
        long,
        value_name = "Q1,Q2,...",
        value_delimiter = ',',
        value_parser = angle,
        allow_negative_numbers = true,
        allow_hyphen_values = true
    )]
    pub(crate) pose: Vec<f64>,
    /// Position of the tool in the base's frame, m; its x axis points along the normal
    #[arg(long, value_name = "X,Y,Z", value_delimiter = ',', num_args = 1, allow_hyphen_values = true)]
    pub(crate) at: Vec<f64>,
    /// Contact normal in the base's frame, from the tool into the workpiece
    #[arg(long, value_name = "X,Y,Z", value_delimiter = ',', required = true, allow_hyphen_values = true)]
    pub(crate) normal: Vec<f64>,
    /// Hold the tool's other directions by position control [default: they are free]
    #[arg(long)]
    pub(crate) hold: bool,
    /// Also simulate the whole arm with a multisine on the drive, and compare the axis with the result
    #[arg(long)]
    pub(crate) measure: bool,
    /// Stiffness of force sensor and workpiece, N/m
    #[arg(long, value_name = "N/M", default_value_t = 2e4)]
    pub(crate) contact_stiffness: f64,
    /// Damping of force sensor and workpiece, N s/m
    #[arg(long, value_name = "NS/M", default_value_t = 40.0)]
    pub(crate) contact_damping: f64,
    /// Machine file to write (TOML), as input of analyze, run, sweep and why
    #[arg(long, short, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) out: Option<PathBuf>,
    /// Map of the force bandwidth over positions at the tool's height: x from, to, count, y from, to, count
    #[arg(long, value_name = "X0,X1,NX,Y0,Y1,NY", value_delimiter = ',', allow_hyphen_values = true)]
    pub(crate) map: Vec<f64>,
    /// Map to write: a table (.csv) or a page with drawings (.html)
    #[arg(long, value_name = "FILE", requires = "map", value_hint = ValueHint::FilePath)]
    pub(crate) map_out: Option<PathBuf>,
    /// Print as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Reads an angle in rad, or in degrees if the text ends in `deg`. Returns rad.
fn angle(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let (number, factor) =
        text.strip_suffix("deg").map_or((text, 1.0), |degrees| (degrees, std::f64::consts::PI / 180.0));
    match number.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value * factor),
        _ => Err("not a number of rad, or of degrees as in '35 deg'".into()),
    }
}
