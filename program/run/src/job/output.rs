//! Files that a job writes at its end, as values: tables and a page.
//!
//! A page has the digest of itself in its last line: a cut or changed one is known.

use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use sha2::{Digest, Sha256};

use super::manifest::{REPORT, hexadecimal};
use crate::{RunError, confirm, replace};

/// Bytes of an output; `None` where this job has no such file.
pub type Content = Result<Option<Vec<u8>>, RunError>;

/// A file that jobs `J` write at their end, from their session and report.
pub struct Output<J, S, R> {
    /// Its name in the directory.
    pub name: &'static str,
    content: fn(&J, &S, &R) -> Content,
    is_page: bool,
}

impl<J, S, R> Output<J, S, R> {
    /// A file that is formed from the checkpoint to the same bytes, whenever its job is asked for again.
    pub fn table(name: &'static str, content: fn(&J, &S, &R) -> Content) -> Self {
        Self {
            name,
            content,
            is_page: false,
        }
    }

    /// `report.html`, which tells how long the job took: it is formed once, and known by its digest.
    pub fn page(content: fn(&J, &S, &R) -> Content) -> Self {
        Self {
            name: REPORT,
            content,
            is_page: true,
        }
    }

    /// Writes the file into a directory.
    pub fn write(
        &self,
        directory: &Path,
        job: &J,
        session: &S,
        report: &R,
    ) -> Result<(), RunError> {
        match (self.content)(job, session, report)? {
            None => Ok(()),
            Some(bytes) if self.is_page => replace(&directory.join(self.name), &sealed(bytes)),
            Some(bytes) => replace(&directory.join(self.name), &bytes),
        }
    }

    /// Makes sure that the file is there as it was written; one that is not there is made anew.
    ///
    /// # Errors
    /// [`RunError::Changed`] where it is another.
    pub fn confirm(
        &self,
        directory: &Path,
        job: &J,
        session: &S,
        report: &R,
    ) -> Result<(), RunError> {
        let path = directory.join(self.name);
        if !self.is_page {
            let bytes = (self.content)(job, session, report)?;
            return bytes.map_or(Ok(()), |bytes| confirm(&path, &bytes));
        }
        match fs::read(&path) {
            Ok(found) if is_sealed(&found) => Ok(()),
            Ok(_) => Err(RunError::Changed { file: path }),
            Err(error) if error.kind() == ErrorKind::NotFound => {
                self.write(directory, job, session, report)
            }
            Err(error) => Err(RunError::reading(path)(error)),
        }
    }
}

/// Beginning of the last line of a page; the SHA-256 of all before that line follows.
const BEFORE: &str = "<!-- sha256 of all before: ";

fn sealed(mut page: Vec<u8>) -> Vec<u8> {
    if !page.ends_with(b"\n") {
        page.push(b'\n');
    }
    let digest = Sha256::digest(&page);
    let digits = hexadecimal(&digest);
    page.extend_from_slice(format!("{BEFORE}{digits} -->\n").as_bytes());
    page
}

fn is_sealed(text: &[u8]) -> bool {
    let mut places = text.windows(BEFORE.len());
    let page = places.rposition(|place| place == BEFORE.as_bytes());
    page.is_some_and(|end| sealed(text[..end].to_vec()) == text)
}
