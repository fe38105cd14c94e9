//! Arms as axes: the machine file of an arm along a contact normal, and its force bandwidth.

mod axis_file;
mod error;
mod map;

pub use axis_file::{AxisFile, ToolContact, axis_file, distrust, gain_in_words};
pub use error::ArmFileError;
pub use map::{Grid, MapPoint, MapValues, NoAxis, bandwidth_map, map_csv, tool_target, without_axis};
