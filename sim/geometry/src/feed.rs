//! The sideways motion of the tip.

use feeler_plant::description::{Knot, Profile};

use crate::error::GeometryError;

/// Lateral position of the tip over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Feed {
    /// Time, lateral position `[y, z]` and velocity.
    points: Vec<(f64, [f64; 2], [f64; 2])>,
}

impl Feed {
    /// A constant velocity from a start.
    pub fn line(start_m: [f64; 2], velocity_m_per_s: [f64; 2]) -> Self {
        Self { points: vec![(0.0, start_m, velocity_m_per_s)] }
    }

    /// A smooth path through points `(time in s, [y, z] in m)`. It consists of cubics whose velocity at each
    /// point is that from the previous to the next. The velocity is zero at both ends, and the tip rests
    /// outside the path. A path of straight lines needs points along them.
    ///
    /// # Errors
    /// [`GeometryError::Path`] for times that do not increase, [`GeometryError::EmptyPath`].
    pub fn path(points: &[(f64, [f64; 2])]) -> Result<Self, GeometryError> {
        if points.is_empty() {
            return Err(GeometryError::EmptyPath);
        }
        let rises = |pair: &[(f64, [f64; 2])]| pair[1].0 > pair[0].0;
        if let Some(index) = points.windows(2).position(|pair| !rises(pair)) {
            return Err(GeometryError::Path { index: index + 1, t_s: points[index + 1].0 });
        }
        let last = points.len() - 1;
        let velocity = |i: usize| {
            if i == 0 || i == last {
                return [0.0; 2];
            }
            let ((t0, p0), (t1, p1)) = (points[i - 1], points[i + 1]);
            [0, 1].map(|k| (p1[k] - p0[k]) / (t1 - t0))
        };
        Ok(Self { points: points.iter().enumerate().map(|(i, (t, p))| (*t, *p, velocity(i))).collect() })
    }

    /// Reads a path from CSV with the header `t_s,y_m,z_m`.
    ///
    /// # Errors
    /// [`GeometryError::Line`] for a line that is not three numbers, and those of [`Self::path`].
    pub fn read_path(text: &str) -> Result<Self, GeometryError> {
        let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
        match lines.next() {
            Some((_, header)) if header.split(',').map(str::trim).eq(["t_s", "y_m", "z_m"]) => {}
            _ => {
                return Err(GeometryError::Line {
                    line: 1,
                    what: "the header is not `t_s,y_m,z_m`".into(),
                    remedy: "write `t_s,y_m,z_m` as the first line",
                });
            }
        }
        let mut points = Vec::new();
        for (i, line) in lines {
            let numbers: Vec<f64> = line
                .split(',')
                .filter_map(|field| field.trim().parse().ok())
                .filter(|x: &f64| x.is_finite())
                .collect();
            let &[t, y, z] = numbers.as_slice() else {
                return Err(GeometryError::Line {
                    line: i + 1,
                    what: format!("`{}` is not three finite numbers", line.trim()),
                    remedy: "write time, y and z, separated by commas",
                });
            };
            points.push((t, [y, z]));
        }
        Self::path(&points)
    }

    /// Lateral position and velocity at a time.
    pub(crate) fn at(&self, t_s: f64) -> ([f64; 2], [f64; 2]) {
        let next = self.points.partition_point(|(t, ..)| *t <= t_s);
        let Some(i) = next.checked_sub(1) else { return (self.points[0].1, [0.0; 2]) };
        let (t0, p0, v0) = self.points[i];
        let Some(&(t1, p1, v1)) = self.points.get(next) else {
            return ([0, 1].map(|k| p0[k] + v0[k] * (t_s - t0)), v0);
        };
        let knot = |t_s, k: usize, p: [f64; 2], v: [f64; 2]| Knot { t_s, offset_m: p[k], rate_m_per_s: v[k] };
        let [y, z] = [0, 1].map(|k| Profile::between(&knot(t0, k, p0, v0), &knot(t1, k, p1, v1), t_s));
        ([y.0, z.0], [y.1, z.1])
    }

    /// Time at the last point of its path, s.
    pub fn end_s(&self) -> f64 {
        self.points[self.points.len() - 1].0
    }

    /// Times of the path's points strictly within `0..duration_s`.
    pub(crate) fn times(&self, duration_s: f64) -> impl Iterator<Item = f64> {
        self.points.iter().map(|(t, ..)| *t).filter(move |t| *t > 0.0 && *t < duration_s)
    }
}
