//! Where a file comes from: enough to make it again, nothing that changes between two runs.
//!
//! Tool, version, effective settings and content hashes of the inputs; no times, paths or thread
//! counts. The request hash covers all of them: a file whose request hash still fits is up to date.

use std::collections::BTreeMap;
use std::io;
use std::io::Read;
use std::path::Path;

use niji_radiometry::open_file;
use sha2::Digest;
use sha2::Sha256;

use crate::attributes;
use crate::checksum::hexadecimal;
use crate::error::Error;
use crate::exr_read;

/// Name of the item that holds the tool.
const TOOL: &str = "niji:tool";
/// Name of the item that holds the version.
const VERSION: &str = "niji:version";
/// Name of the item that holds the settings.
const SETTINGS: &str = "niji:settings";
/// Start of the names of the items that hold input hashes.
const INPUT: &str = "niji:input.";
/// Name of the item that holds the request hash.
const REQUEST_HASH: &str = "niji:requestHash";

/// Where a file comes from.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Provenance {
    /// The stage that made it, say `niji scatter`.
    pub tool: String,
    /// Version of the program.
    pub version: String,
    /// Effective settings as canonical JSON.
    pub settings: String,
    /// SHA-256 of each input file by its role, in hexadecimal.
    pub inputs: BTreeMap<String, String>,
}

impl Provenance {
    /// SHA-256 over tool, version, settings and inputs, in hexadecimal.
    #[must_use]
    pub fn request_hash(&self) -> String {
        let mut hasher = Sha256::new();
        let mut add = |text: &str| {
            hasher.update((text.len() as u64).to_le_bytes());
            hasher.update(text.as_bytes());
        };
        add(&self.tool);
        add(&self.version);
        add(&self.settings);
        for (role, hash) in &self.inputs {
            add(role);
            add(hash);
        }
        hexadecimal(&hasher.finalize())
    }

    /// The provenance as named texts: EXR attributes and VDB metadata alike.
    #[must_use]
    pub fn to_text_items(&self) -> Vec<(String, String)> {
        let mut items = vec![
            (TOOL.to_owned(), self.tool.clone()),
            (VERSION.to_owned(), self.version.clone()),
            (SETTINGS.to_owned(), self.settings.clone()),
            (REQUEST_HASH.to_owned(), self.request_hash()),
        ];
        for (role, hash) in &self.inputs {
            items.push((format!("{INPUT}{role}"), hash.clone()));
        }
        items
    }

    /// Whether a named text is one of a provenance.
    pub(crate) fn owns(name: &str) -> bool {
        [TOOL, VERSION, SETTINGS, REQUEST_HASH].contains(&name) || name.starts_with(INPUT)
    }

    /// Reads the provenance back from named texts; `None` where a file carries none.
    #[must_use]
    pub fn from_text_items<'a>(
        items: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Option<Self> {
        let mut provenance = Self::default();
        for (name, text) in items {
            match name {
                TOOL => text.clone_into(&mut provenance.tool),
                VERSION => text.clone_into(&mut provenance.version),
                SETTINGS => text.clone_into(&mut provenance.settings),
                _ => {
                    if let Some(role) = name.strip_prefix(INPUT) {
                        provenance.inputs.insert(role.to_owned(), text.to_owned());
                    }
                }
            }
        }
        (!provenance.tool.is_empty()).then_some(provenance)
    }
}

/// The provenance of an EXR file, from its header alone; `None` where it carries none.
///
/// # Errors
/// If the file is missing, its header is damaged, or it is shorter than the header promises.
pub fn read_provenance(path: &Path) -> Result<Option<Provenance>, Error> {
    let headers = exr_read::read_headers(path)?;
    let first = headers.first().map(|(_, it)| attributes::texts(it));
    Ok(first.and_then(Provenance::from_text_items))
}

/// SHA-256 of a file's content, in hexadecimal.
///
/// # Errors
/// If the file cannot be read, or is one that need not end.
pub fn content_hash(path: &Path) -> io::Result<String> {
    let (mut file, _) = open_file(path)?;
    let mut hasher = Sha256::new();
    let mut buffer = vec![0; 1 << 20];
    loop {
        let n_bytes = file.read(&mut buffer)?;
        if n_bytes == 0 {
            return Ok(hexadecimal(&hasher.finalize()));
        }
        hasher.update(&buffer[..n_bytes]);
    }
}

/// SHA-256 of a text, in hexadecimal.
#[must_use]
pub fn text_hash(text: &str) -> String {
    hexadecimal(&Sha256::digest(text))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> Provenance {
        Provenance {
            tool: "niji scatter".to_owned(),
            version: "0.1.0".to_owned(),
            settings: r#"{"theory":"airy"}"#.to_owned(),
            inputs: BTreeMap::from([("airy".to_owned(), "00ff".to_owned())]),
        }
    }

    #[test]
    fn text_items_round_trip() {
        let items = example().to_text_items();
        let borrowed = items
            .iter()
            .map(|(name, text)| (name.as_str(), text.as_str()));
        assert_eq!(Provenance::from_text_items(borrowed), Some(example()));
        assert_eq!(Provenance::from_text_items([("owner", "somebody")]), None);
    }

    #[test]
    fn every_part_of_a_request_changes_its_hash() {
        let hash = example().request_hash();
        assert_eq!(hash.len(), 64);
        assert_ne!(
            hash,
            Provenance {
                version: "0.1.1".to_owned(),
                ..example()
            }
            .request_hash()
        );
        assert_ne!(
            hash,
            Provenance {
                inputs: BTreeMap::new(),
                ..example()
            }
            .request_hash()
        );
        // Length prefixes keep neighbors apart.
        let shifted = Provenance {
            tool: "niji scatter0".to_owned(),
            version: ".1.0".to_owned(),
            ..example()
        };
        assert_ne!(hash, shifted.request_hash());
    }

    #[test]
    fn the_hash_of_a_file_is_the_published_sha_256() {
        let path = std::path::PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml"));
        assert_eq!(content_hash(&path).unwrap().len(), 64);
        // FIPS 180-2, appendix B.1.
        assert_eq!(
            text_hash("abc"),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
    }
}
