//! The problem library: Poisson systems of the literature, each as scene text.
//!
//! A library system is one TOML text with three tables. A scene takes in the table `[system]` when
//! it says `library = "rigid-body"`. The table `[about]` tells what the system is and where it is
//! written. The table `[default]` holds an initial state and a time step to start from.
//!
//! ```
//! let top = leafwise_systems::find("heavy-top").expect("the heavy top is in the library");
//! assert_eq!(top.dimension()?, 6);
//! println!("{}: {}", top.about()?.title, top.about()?.reference);
//! assert_eq!(leafwise_systems::nearest("heavytop"), Some("heavy-top"));
//! # Ok::<(), leafwise_systems::SystemError>(())
//! ```
//!
//! Signs follow each text's `convention`. The paper's x' = {H, x} is `{H,x}`; most
//! of the literature writes `{x,H}`.
//!
//! - [`about`](About): title, summary, literature and orbit of a system.
//! - [`defaults`](Defaults): the initial state and time step to start from.
//! - `ids`: their ids.
//! - [`library`](LibrarySystem): the systems by id.
//! - `part`: the systems as parts of the registry.
//! - [`error`](SystemError): errors of reading a text.

#[macro_use]
mod ids;

mod about;
mod defaults;
mod error;
mod library;
mod part;

pub use about::{About, Reference};
pub use defaults::{Defaults, PacedDefaults};
pub use error::SystemError;
pub use library::{LibrarySystem, all, find, nearest};
