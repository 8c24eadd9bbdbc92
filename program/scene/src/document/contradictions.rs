//! Keys of different tables that do not stand beside one another, as the declaration of each says.

use super::located::{Located, Place};
use super::scene::SceneDocument;
use super::schema::declared;
use super::shape::Beside;
use crate::diagnostic::SceneDiagnostic;

/// Where the value of a key stands in a scene that was read; `None` where the scene does not have it.
type PlaceOf = fn(&SceneDocument) -> Option<Place>;

/// The keys that are declared not to stand beside keys of other tables, and these.
const PLACES: [(&str, PlaceOf); 11] = [
    ("system.forces", |scene| {
        scene.system.forces.one_form.as_ref().map(Located::place)
    }),
    ("system.torque", |scene| {
        scene.system.forces.torque.as_ref().map(Located::place)
    }),
    ("system.damping", |scene| {
        let damping = scene.system.forces.damping.as_ref();
        damping.map(|damping| damping.rate.place())
    }),
    ("system.friction", |scene| {
        scene.system.forces.friction.as_ref().map(Located::place)
    }),
    ("system.noise", |scene| {
        let first = scene.system.noise.first();
        first.map(|channel| channel.hamiltonian.place())
    }),
    ("method.pace", |scene| {
        scene.method.pace.as_ref().map(Located::place)
    }),
    ("run.stop", |scene| {
        scene.run.stop.as_ref().map(Located::place)
    }),
    ("run.section", |scene| {
        let section = scene.run.section.as_ref();
        section.map(|section| section.at.place())
    }),
    ("run.section.set", |scene| {
        let section = scene.run.section.as_ref();
        let set = section.and_then(|section| section.set.as_ref());
        set.map(Located::place)
    }),
    ("run.record.interval", |scene| {
        scene.run.record.interval.as_ref().map(Located::place)
    }),
    ("run.record.times", |scene| {
        scene.run.record.times.as_ref().map(Located::place)
    }),
];

impl SceneDocument {
    /// Refusal of the first key that is declared not to stand beside another table's. An ensemble's records are looked at
    /// where they stand in the place of the run's.
    pub(crate) fn contradiction(&self) -> Option<SceneDiagnostic> {
        let place_of = |path: &str| {
            let (_, place) = PLACES.iter().find(|(known, _)| *known == path)?;
            place(self)
        };
        PLACES.iter().find_map(|(path, place)| {
            let place = place(self)?;
            let key = declared(path)?;
            key.beside.iter().find_map(|beside| {
                let (stands, message, help) = match beside {
                    Beside::Elsewhere {
                        paths,
                        message,
                        help,
                    } => {
                        let is_there = paths.iter().any(|path| place_of(path).is_some());
                        (!is_there, *message, *help)
                    }
                    Beside::Without {
                        path,
                        message,
                        help,
                    } => (place_of(path).is_some(), *message, *help),
                    Beside::InPlaceOf { .. } | Beside::Keys { .. } | Beside::Note(_) => {
                        return None;
                    }
                };
                let refusal = || self.diagnostic(&place, message, "here", Some(help.to_owned()));
                (!stands).then(refusal)
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::schema::each_key;

    #[test]
    fn every_key_that_a_declaration_refuses_is_found_in_a_scene() {
        let is_known = |path: &str| PLACES.iter().any(|(known, _)| *known == path);
        let mut count = 0;
        for (path, key) in each_key() {
            for beside in key.beside {
                let others: &[&str] = match beside {
                    Beside::Elsewhere { paths, .. } => paths,
                    Beside::Without { path, .. } => &[path],
                    Beside::InPlaceOf { .. } | Beside::Keys { .. } | Beside::Note(_) => continue,
                };
                // Composed in the place of the run's.
                let own = path.replace("ensemble.record.", "run.record.");
                assert!(is_known(&own), "{path}");
                assert!(others.iter().all(|other| is_known(other)), "{path}");
                count += 1;
            }
        }
        assert!(count >= 8, "{count}");
    }
}
