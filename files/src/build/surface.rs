//! The gap of a contact over time: from shapes and a feed, or as given points.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use feeler_catalogue::{Contents, Key, Keyed, LAW};
use feeler_geometry::{Feed, GeometryError, Material, Placement, Shape, hertz_stiffness};
use feeler_plant::description::{Contact, ContactLaw, Elements, Engagement, Knot, Machine, Profile};
use feeler_problem::{Problem, Remedy};

use super::shapes::{FileError, text_of};
use super::{Builder, Item};
use crate::gaps::Travel;
use crate::keys::CONTACTS;
use crate::keys::surface::{
    ERROR, FEED, FILE, FeedKeys, MATERIAL, OFFSET, PROFILE, RATE, SURFACE, ShapeFile, TIP, WORKPIECE,
};
use crate::tree::{locate, node_at};

impl Builder<'_> {
    /// The gap of a contact over time; `None` if the contact has no such keys, or if they have mistakes.
    pub(super) fn gap(&mut self, item: Item<'_>, fields: &Contents, sound: bool) -> Option<Arc<Profile>> {
        let surface = fields.table(&SURFACE);
        let profile = fields.table(&PROFILE);
        if let (Some(_), Some(_)) = (surface, profile) {
            let message = "a surface and a profile both define the motion of the gap";
            self.problems.add(
                item.place(PROFILE.name),
                item.key(PROFILE.name),
                message,
                "remove one of them",
            );
            return None;
        }
        if !sound {
            return None;
        }
        let (key, found) = match (surface, profile) {
            (Some(_), _) if self.rotational() => {
                let message = "shapes touch along a line, and this axis is rotational";
                let remedy = format!("write the gap out as `{}`", PROFILE.name);
                self.problems.add(item.place(SURFACE.name), item.key(SURFACE.name), message, remedy);
                return None;
            }
            (Some(surface), _) => (SURFACE.name, self.surface(item, surface)?),
            (_, Some(profile)) => (PROFILE.name, written(profile)),
            _ => return None,
        };
        let noted = |problem: Problem| {
            self.problems.add(item.place(key), item.key(key), problem.message, problem.remedy);
        };
        found.map_err(noted).ok()
    }

    /// The default stiffness of a contact: Hertz's, between two materials.
    pub(super) fn stiffness_of_materials(
        &mut self,
        item: Item<'_>,
        fields: &Contents,
        law: ContactLaw,
    ) -> Option<f64> {
        let stiffness = Contact::STIFFNESS.key.name;
        if item.table.contains_key(stiffness) {
            return None;
        }
        let parts =
            [TIP, WORKPIECE].map(|key| fields.table(&SURFACE).and_then(|surface| surface.table(&key)));
        let materials = parts.map(|part| part.and_then(|part| part.value::<Material>(&MATERIAL)));
        let ([Some(tip), Some(workpiece)], ContactLaw::Hertz) = (materials, law) else {
            let message = format!("`{stiffness}` is missing");
            let remedy = format!(
                "add `{stiffness} = \"... N/m\"`: k; or `{LAW} = \"hertz\"` and a `{}` of tip and workpiece \
                 in `{}`",
                MATERIAL.name, SURFACE.name
            );
            self.problems.add(item.at, item.key(stiffness), message, remedy);
            return None;
        };
        let radii = parts.map(|part| match Shape::read(part?) {
            Some(Shape::Ball { radius_m }) => Some(radius_m),
            Some(Shape::Cuboid { .. }) => Some(f64::INFINITY),
            Some(_) => None,
            None => ShapeFile::read(part?).map(|_| f64::INFINITY),
        });
        match radii {
            [Some(a), Some(b)] if a.is_finite() || b.is_finite() => {
                Some(hertz_stiffness((a, tip), (b, workpiece)))
            }
            _ => {
                let message = "these two shapes do not touch in a point of one curvature, so that Hertz's \
                               law for balls does not hold";
                let remedy = format!("write `{stiffness}`, or give one of them the shape of a ball");
                self.problems.add(item.at, item.key(stiffness), message, remedy);
                None
            }
        }
    }

    fn surface(&mut self, item: Item<'_>, fields: &Contents) -> Option<Result<Arc<Profile>, Problem>> {
        let tip = self.shape(item, &TIP, fields.table(&TIP)?);
        let workpiece = self.shape(item, &WORKPIECE, fields.table(&WORKPIECE)?);
        let feed = self.feed(item, fields.value(&FEED)?);
        let error_m = fields.value(&ERROR)?;
        let (feed, duration_s) = feed?;
        let travel = Travel { tip: tip?, workpiece: workpiece?, feed, duration_s, error_m };
        let problem = |error: GeometryError| Problem::new("", error.to_string(), error.remedy());
        Some(self.draft.gaps.of(item.name, travel).map_err(problem))
    }

    fn shape(&mut self, item: Item<'_>, part: &Key, fields: &Contents) -> Option<(Shape, Placement)> {
        let shape = match ShapeFile::read(fields) {
            Some(written) => self.file(item, part, written.file(), |path| written.load(path))?,
            None => Shape::read(fields)?,
        };
        Some((shape, Placement::read(fields)?))
    }

    fn feed(&mut self, item: Item<'_>, written: FeedKeys) -> Option<(Feed, f64)> {
        match written {
            FeedKeys::Line { start_m, velocity_m_per_s, duration_s } => {
                Some((Feed::line(start_m, velocity_m_per_s), duration_s))
            }
            FeedKeys::Path { file } => {
                let wanted = "a CSV file with the header `t_s,y_m,z_m`";
                let feed =
                    self.file(item, &FEED, &file, |path| Ok(Feed::read_path(&text_of(path, wanted)?)?))?;
                let end_s = feed.end_s();
                Some((feed, end_s))
            }
        }
    }

    /// Reads the file that a part of a surface names.
    fn file<T>(
        &mut self,
        item: Item<'_>,
        part: &Key,
        name: &str,
        read: impl Fn(&Path) -> Result<T, FileError>,
    ) -> Option<T> {
        let key = item.key(&format!("{}.{}.{FILE}", SURFACE.name, part.name));
        let origin = locate(&self.draft.root, &key).0.unwrap_or_else(|| item.at.clone());
        let path: PathBuf = self.draft.sources.0[origin.source].directory.join(name);
        match read(&path) {
            Ok(found) => Some(found),
            Err(error) => {
                let message = format!("{}: {error}", path.display());
                self.problems.add(&origin, key, message, error.remedy());
                None
            }
        }
    }

    /// Adds the gaps of contacts to a machine, and records tips that start inside the workpiece.
    pub(super) fn gaps(&mut self, machine: &mut Machine, found: Elements<(Contact, Option<Arc<Profile>>)>) {
        for (name, (contact, profile)) in found {
            if let Some(profile) = profile {
                let position = |name: &String| machine.bodies.get(name).map_or(0.0, |body| body.position_m);
                let [tip, workpiece] = &contact.between;
                let depth_m = position(tip) - position(workpiece) - contact.gap_m - profile.at(0.0).0;
                let surface = node_at(&self.draft.root, &[CONTACTS.table, &name, SURFACE.name]);
                if let Some(at) =
                    surface.filter(|_| depth_m > 0.0 && contact.engagement == Engagement::Unilateral)
                {
                    let error = GeometryError::Overlap { depth_m };
                    let key = format!("{}.{name}.{}", CONTACTS.table, SURFACE.name);
                    self.problems.add_error(&at.origin, key, &error);
                }
                machine.profiles.insert(name.clone(), profile);
            }
            machine.contacts.insert(name, contact);
        }
    }
}

/// A profile given by points.
fn written(fields: &Contents) -> Result<Arc<Profile>, Problem> {
    let [offset, rate] = [OFFSET, RATE].map(|key| fields.value::<Vec<(f64, f64)>>(&key).unwrap_or_default());
    let profile = if rate.is_empty() {
        Profile::smooth(&offset)
    } else {
        let same = offset.len() == rate.len()
            && offset.iter().zip(&rate).all(|((a, _), (b, _))| a.to_bits() == b.to_bits());
        if !same {
            let message =
                format!("{} offsets and {} rates do not have the same times", offset.len(), rate.len());
            return Err(Problem::new("", message, "give each offset its rate"));
        }
        let knots: Vec<Knot> = offset
            .iter()
            .zip(&rate)
            .map(|((t, p), (_, v))| Knot { t_s: *t, offset_m: *p, rate_m_per_s: *v })
            .collect();
        Profile::new(&knots)
    };
    profile.map(Arc::new)
}
