//! Plugins: parts of third parties in shared libraries, found, checked, opened and registered.
//!
//! Opening a library runs its code, which nothing inside this process can contain: a plugin is
//! trusted as much as this program is. The checks here catch mistakes, not malice.
//!
//! The order, each step before the next:
//!
//! 1. [`find`]: an explicit path, or a name in the folders of the search path;
//! 2. [`side_file`], `file`, `object`: checks of the file that run nothing of it;
//! 3. [`probe`]: opened and tried in a child process, where it may crash or hang;
//! 4. `library`, `floating_point`: opened for good;
//! 5. `handshake`: everything it declares copied and checked, as a [`PluginDeclaration`];
//! 6. `opened`, `smoke`: every function called at a few points; `trial_points`: these points; `smoke_failure`: its
//!    refusals;
//! 7. [`loader`]: registered, all parts or none.
//!
//! Parts are registered from `foreign` (a library's functions as parts) or from `formulas` (its expressions as parts).
//! For the latter everything works that works for a built-in part. The module `host` hands the host's own systems and
//! realizations to plugins. Refusals of a plugin are values of [`error`].

pub mod declaration;
pub mod error;
mod exits;
mod file;
pub mod find;
mod floating_point;
mod foreign;
mod formulas;
mod handshake;
mod host;
mod library;
pub mod loader;
mod object;
mod opened;
mod part;
mod platform;
pub mod probe;
pub mod side_file;
mod smoke;
mod smoke_failure;
mod trial_points;

pub use declaration::{PartDeclaration, PluginDeclaration, ValuePath};
pub use error::{PluginError, Refusal};
pub use find::SearchPath;
pub use floating_point::change_of_arithmetic;
pub use loader::{LoadedPlugin, Loader, PluginRequest};
pub use probe::{ProbeCommand, run_probe};
pub use smoke::Tried;
pub use smoke_failure::SmokeFailure;

/// Keeps standard output for this program: returns a handle of it. From now on all that libraries print there goes to
/// standard error.
///
/// # Errors
/// The system's, where descriptors cannot be copied; nothing is changed then.
pub fn own_output() -> std::io::Result<std::fs::File> {
    platform::own_output()
}
