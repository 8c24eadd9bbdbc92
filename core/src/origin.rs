//! Where a part comes from.

use std::fmt;
use std::path::PathBuf;

use serde::Serialize;

/// Origin of a part of the [`Registry`](crate::Registry): a crate of the program or a library loaded at run time.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Origin {
    /// A crate linked into the program.
    BuiltIn {
        /// The crate's name.
        package: String,
        /// Its version.
        version: String,
    },
    /// A shared library loaded at run time.
    Library {
        /// The absolute path it was loaded from.
        path: PathBuf,
        /// The SHA-256 of the file, in hexadecimal.
        sha256: String,
        /// The version the library states.
        version: String,
        /// The plugin interface it was built for, as `major.minor`.
        abi: String,
    },
}

impl Origin {
    /// A crate of the program: `Origin::built_in(env!("CARGO_PKG_NAME"), env!("CARGO_PKG_VERSION"))`.
    pub fn built_in(package: impl Into<String>, version: impl Into<String>) -> Self {
        Self::BuiltIn {
            package: package.into(),
            version: version.into(),
        }
    }
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::BuiltIn { package, version } => write!(f, "{package} {version} (built in)"),
            Self::Library {
                path,
                sha256,
                version,
                abi,
            } => {
                let short = sha256.get(..12).unwrap_or(sha256);
                let path = path.display();
                write!(f, "{path} {version} (abi {abi}, sha256 {short})")
            }
        }
    }
}
