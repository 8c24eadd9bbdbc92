//! Where a plugin is: a path, or a name in the folders of the search path.

use std::collections::BTreeSet;
use std::env;
use std::fs;
use std::path::{Path, PathBuf};

use crate::error::{PluginError, Refusal};
use crate::file::{check_way, unreadable};
use crate::platform;

/// The variable that holds folders to search, separated like those of PATH.
pub const PATH_VARIABLE: &str = "LEAFWISE_PLUGIN_PATH";

/// Folders of the system, searched last.
const SYSTEM_FOLDERS: [&str; 2] = [
    "/usr/local/lib/leafwise/plugins",
    "/usr/lib/leafwise/plugins",
];

/// The folders in which plugins are looked for by name: absolute ones, each searched without its
/// subfolders, and never the folder the program happens to run in.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SearchPath {
    folders: Vec<PathBuf>,
}

impl SearchPath {
    /// These folders; relative ones are left out.
    pub fn new(folders: impl IntoIterator<Item = PathBuf>) -> Self {
        Self {
            folders: folders.into_iter().filter(|f| f.is_absolute()).collect(),
        }
    }

    /// The folders of `LEAFWISE_PLUGIN_PATH`, then `leafwise/plugins` in the user's data folder, then
    /// those of the system. A program that runs with raised privileges reads no environment: it
    /// searches those of the system only.
    pub fn of_environment() -> Self {
        let system = SYSTEM_FOLDERS.iter().map(PathBuf::from);
        if platform::has_raised_privileges() {
            return Self::new(system);
        }
        let listed = env::var_os(PATH_VARIABLE).unwrap_or_default();
        let listed: Vec<PathBuf> = env::split_paths(&listed).collect();
        let own = user_folder("XDG_DATA_HOME", ".local/share").map(|f| f.join("plugins"));
        Self::new(listed.into_iter().chain(own).chain(system))
    }

    /// The folders, in the order searched.
    pub fn folders(&self) -> &[PathBuf] {
        &self.folders
    }

    /// The file that `asked` stands for. A name with a separator is a path, relative to `base` (the folder of the
    /// scene). A bare name is searched for and never taken from there: `acme` is `libacme.so` or `acme.so` in the first
    /// folder that has one of them. The result is absolute and free of symbolic links; nobody else may change where the
    /// path leads.
    ///
    /// # Errors
    /// [`Refusal::NoSuchFile`], [`Refusal::NotFound`], [`Refusal::WritableByOthers`], [`Refusal::OwnedByOther`].
    pub fn find(&self, asked: &Path, base: &Path) -> Result<PathBuf, PluginError> {
        let is_bare = asked.components().count() == 1 && !asked.is_absolute();
        let path = base.join(asked);
        if !is_bare {
            return canonical(&path).map_err(|refusal| refusal.of(path));
        }
        for folder in &self.folders {
            for name in file_names(asked) {
                let path = folder.join(name);
                if path.is_file() {
                    return canonical(&path).map_err(|refusal| refusal.of(path));
                }
            }
        }
        let searched = self.folders.clone();
        let is_here = path.exists();
        Err(Refusal::NotFound { searched, is_here }.of(asked))
    }

    /// Every shared library in the folders, each file once, sorted within a folder.
    pub fn all(&self) -> Vec<PathBuf> {
        let mut found = Vec::new();
        let mut known = BTreeSet::new();
        for folder in &self.folders {
            let Ok(entries) = fs::read_dir(folder) else {
                continue;
            };
            let mut paths: Vec<PathBuf> = entries
                .filter_map(|entry| Some(entry.ok()?.path()))
                .filter(|path| is_library(path))
                .collect();
            paths.sort();
            for path in paths {
                let metadata = fs::metadata(&path);
                let file = metadata.ok().filter(fs::Metadata::is_file);
                let is_new = file.is_some_and(|file| known.insert(platform::identity(&file)));
                if is_new && let Ok(path) = path.canonicalize() {
                    found.push(path);
                }
            }
        }
        found
    }
}

/// The folder `leafwise` in a folder of the user's.
pub(crate) fn user_folder(variable: &str, below_home: &str) -> Option<PathBuf> {
    let absolute = |name: &str| {
        env::var_os(name)
            .map(PathBuf::from)
            .filter(|f| f.is_absolute())
    };
    let base = absolute(variable).or_else(|| Some(absolute("HOME")?.join(below_home)))?;
    Some(base.join("leafwise"))
}

/// Where a path leads, if nobody else may change that.
fn canonical(path: &Path) -> Result<PathBuf, Refusal> {
    let absolute = std::path::absolute(path).map_err(unreadable)?;
    if !fs::metadata(&absolute).map_err(unreadable)?.is_file() {
        return Err(Refusal::NotAFile);
    }
    check_way(&absolute)?;
    absolute.canonicalize().map_err(unreadable)
}

/// Whether a file is called like a shared library.
fn is_library(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| extension == env::consts::DLL_EXTENSION)
}

/// File names that a plugin of this name may have, in the order searched.
fn file_names(name: &Path) -> Vec<PathBuf> {
    if is_library(name) {
        return vec![name.to_owned()];
    }
    let (prefix, extension) = (env::consts::DLL_PREFIX, env::consts::DLL_EXTENSION);
    let shown = name.display();
    [prefix, ""]
        .map(|prefix| PathBuf::from(format!("{prefix}{shown}.{extension}")))
        .to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder_with(files: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for file in files {
            fs::write(folder.path().join(file), file).expect("a writable folder");
        }
        folder
    }

    #[test]
    fn a_name_is_searched_in_order_and_a_path_from_its_base() {
        let (first, second) = (folder_with(&["acme.so"]), folder_with(&["libacme.so"]));
        let path = SearchPath::new([first.path().to_owned(), second.path().to_owned()]);
        let find = |asked: &str, base: &Path| path.find(Path::new(asked), base);
        let in_first = first.path().canonicalize().expect("it is there");
        assert_eq!(find("acme", Path::new("/")), Ok(in_first.join("acme.so")));
        let in_second = second.path().canonicalize().expect("it is there");
        let found = find("./libacme.so", second.path());
        assert_eq!(found, Ok(in_second.join("libacme.so")));
        // A bare name is never that of a file that lies here.
        let planted = folder_with(&["libacme.so", "libother.so"]);
        let found = find("libacme.so", planted.path());
        assert_eq!(found, Ok(in_second.join("libacme.so")));
        let error = find("libother.so", planted.path()).expect_err("not in the search path");
        assert!(
            matches!(error.refusal, Refusal::NotFound { is_here: true, .. }),
            "{error}"
        );
        assert_eq!(
            find("./nothing.so", first.path()).map_err(|e| e.refusal),
            Err(Refusal::NoSuchFile)
        );
    }

    #[test]
    fn the_current_folder_is_never_searched() {
        let path = SearchPath::new([PathBuf::from("."), PathBuf::from("relative")]);
        assert_eq!(path.folders(), [] as [PathBuf; 0]);
        // A file of the folder that tests run in.
        let asked = Path::new("Cargo.toml");
        let error = path.find(asked, Path::new("."));
        let error = error.expect_err("not searched");
        let searched = Vec::new();
        let is_here = true;
        assert_eq!(error.refusal, Refusal::NotFound { searched, is_here });
        assert!(
            error.to_string().contains(
                "a file of that name is in this folder, which is not searched: give a path with a `/`"
            ),
            "{error}"
        );
        assert!(error.to_string().contains("there is none"), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn links_to_one_file_are_one_plugin() {
        let folder = folder_with(&["b.so", "notes.txt"]);
        let links = folder_with(&[]);
        for name in ["a.so", "c.so"] {
            let target = folder.path().join("b.so");
            std::os::unix::fs::symlink(target, links.path().join(name)).expect("a link");
        }
        fs::hard_link(folder.path().join("b.so"), folder.path().join("d.so")).expect("a link");
        let path = SearchPath::new([links.path().to_owned(), folder.path().to_owned()]);
        let file = folder
            .path()
            .canonicalize()
            .expect("it is there")
            .join("b.so");
        assert_eq!(path.all(), [file]);
    }
}
