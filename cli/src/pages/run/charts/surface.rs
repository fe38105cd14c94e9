//! The surface that moves below a tool, and the path of the contact on it.

use feeler_plant::description::{Quantity, SignalName};

use super::{TIME, View, prefix};
use crate::pages::parts::{Chart, ChartKind, Page, Series, by_extremes};

impl View<'_> {
    /// Draws the surface, the tool, and the path along which they touch. Draws nothing if the gap of the main
    /// contact is constant.
    pub(in crate::pages::run) fn surface(&self, page: &mut Page) {
        let charts = self.surface_charts();
        if charts.is_empty() {
            return;
        }
        page.heading("Surface");
        let bands = self.bands(&(0..self.t_s().len()));
        for mut chart in charts {
            chart.together = Some("run");
            chart.bands.clone_from(&bands);
            page.chart(&chart);
        }
    }

    fn surface_charts(&self) -> Vec<Chart> {
        let name = self.main_contact().map(|contact| contact.name.as_str()).unwrap_or_default();
        let (Some(profile), Some(contact)) =
            (self.machine.profiles.get(name), self.machine.contacts.get(name))
        else {
            return Vec::new();
        };
        let t_s = self.t_s();
        let [tip, workpiece] = contact
            .between
            .each_ref()
            .map(|body| self.result.record.column(&SignalName::new(body, Quantity::Position).to_string()));
        let lies = |row: usize| workpiece.map_or(0.0, |column| column[row]) + contact.gap_m;
        let surface: Vec<f64> = (0..t_s.len()).map(|row| lies(row) + profile.at(t_s[row]).0).collect();
        let columns: Vec<&[f64]> = std::iter::once(surface.as_slice()).chain(tip).collect();
        let kept = by_extremes(&columns, t_s.len(), self.most_rows);
        let times = || kept.iter().map(|&row| t_s[row]).collect::<Vec<f64>>();
        let largest = columns.iter().copied().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
        let (scale, name) = prefix(largest);
        let unit = format!("{name}{}", self.units.position);
        let names = ["surface".to_owned(), format!("{}.position", contact.between[0])];
        let mut chart =
            Chart::new(ChartKind::Line, "Surface under the tool.", TIME, format!("position ({unit})"));
        chart.caption = "Where the tool meets the surface, and where the tool is: above it by the depth of \
                         contact, below it by the gap."
            .into();
        chart.x = times();
        chart.series = (names.into_iter().zip(&columns))
            .map(|(name, column)| {
                Series::new(name, &unit, kept.iter().map(|&row| column[row] / scale).collect())
            })
            .collect();
        let touches: Option<Vec<_>> = kept.iter().map(|&row| profile.touch_at(t_s[row])).collect();
        let path = touches.filter(|touches| !touches.is_empty()).map(|touches| {
            let sideways = |axis: usize| touches.iter().map(move |touch| touch[axis]);
            let largest = sideways(1).chain(sideways(2)).fold(0.0, |most: f64, x| most.max(x.abs()));
            let (scale, name) = prefix(largest);
            let unit = format!("{name}m");
            let mut chart =
                Chart::new(ChartKind::Line, "Path of the contact.", TIME, format!("position ({unit})"));
            chart.caption = "The point of the workpiece that the tool meets, along y and z.".into();
            chart.x = times();
            chart.series = [("y", 1), ("z", 2)]
                .map(|(name, axis)| Series::new(name, &unit, sideways(axis).map(|x| x / scale).collect()))
                .into();
            chart
        });
        std::iter::once(chart).chain(path).collect()
    }
}
