//! Controllers.

use feeler_catalogue::Content;
use feeler_control::READS;
use feeler_control::reference::{FOLLOWED, REFERENCE};
use feeler_engine::ControllerUse;

use super::{Writer, inline, inline_of};
use crate::keys::CONTROLLERS;

impl Writer {
    pub(super) fn controller(&mut self, name: &str, controller: &ControllerUse) {
        let spec = &controller.spec;
        self.header(&[CONTROLLERS.table, name]);
        self.form(&CONTROLLERS, &spec.law);
        if let Some(sensor) = &controller.reads {
            self.words(READS.name, sensor);
        }
        self.record(controller);
        self.record(spec);
        self.record(&spec.law);
        let followed = match spec.reference.as_content() {
            Content::Table(table) => inline_of(&REFERENCE, &table),
            content => inline(&content),
        };
        self.line(FOLLOWED.name, followed);
        self.effects(CONTROLLERS.table, name, &controller.effects);
    }
}
