//! Who vouches for a list of files: Ed25519 signatures of manifests and provenances.
//!
//! What is signed is not the bytes of the JSON but a statement of plain lines that both documents give
//! ([`Manifest::statement`](crate::Manifest::statement), [`Provenance::statement`](crate::Provenance::statement)), so
//! that laying the file out anew does no harm and any other program can check it. Keys are PEM files as OpenSSL writes
//! and reads them (`openssl genpkey -algorithm ed25519`, `openssl pkeyutl -verify -rawin`).

use crate::digest::hexadecimal;
use crate::{Error, ErrorKind, Result, Source};
use ed25519_compact::{KeyPair, Seed};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::io::Write;
use std::path::{Path, PathBuf};

/// The one algorithm. **Source** `[RFC8032]`.
const ALGORITHM: &str = "ed25519";
/// Bytes of a file of a key at most.
const LARGEST_KEY: u64 = 1 << 16;

/// A private key.
#[derive(Clone)]
pub struct SigningKey(KeyPair);

impl fmt::Debug for SigningKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "SigningKey({})", self.public())
    }
}

/// A public key; its display is its 32 bytes in hexadecimal digits.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct VerifyingKey(ed25519_compact::PublicKey);

impl fmt::Display for VerifyingKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&hexadecimal(self.0.as_ref()))
    }
}

impl fmt::Debug for VerifyingKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "VerifyingKey({self})")
    }
}

/// A signature as it stands in a manifest or a provenance.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Signature {
    /// Always `ed25519`.
    pub(crate) algorithm: String,
    /// Public key of the signer in hexadecimal digits.
    pub key: String,
    /// The signature in hexadecimal digits.
    pub(crate) value: String,
}

impl SigningKey {
    /// A new key of 32 random bytes.
    ///
    /// # Errors
    /// The system gives no random numbers.
    pub fn generate() -> Result<Self> {
        let mut seed = [0; 32];
        getrandom::fill(&mut seed).map_err(|e| {
            Error::new(
                ErrorKind::Access,
                format!("the system gives no random numbers: {e}"),
            )
        })?;
        Ok(Self(KeyPair::from_seed(Seed::new(seed))))
    }

    /// Reads a private key: PKCS#8 in PEM, not encrypted.
    ///
    /// # Errors
    /// A file that is none.
    pub fn read(path: &Path) -> Result<Self> {
        let text = text(path)?;
        KeyPair::from_pem(&text).map(Self).map_err(|_| {
            let what = if text.contains("ENCRYPTED") {
                "is an encrypted private key, which this program does not open"
            } else if text.contains("PUBLIC KEY") {
                "is a public key; a private one signs"
            } else {
                "is no private key of the form Ed25519, PKCS#8, PEM"
            };
            Error::new(ErrorKind::Format, what).at(path).with_hint(
                "make a pair with `proofmass keygen NAME`, or `openssl genpkey -algorithm ed25519`",
            )
        })
    }

    /// Writes `NAME.key`, which only its owner may read, and `NAME.pub`; neither may be there.
    ///
    /// # Errors
    /// A file of that name is there, or the disk refuses.
    pub fn write(&self, name: &Path) -> Result<[PathBuf; 2]> {
        let with = |ending: &str| {
            let mut all = name.as_os_str().to_owned();
            all.push(ending);
            PathBuf::from(all)
        };
        let places = [with(".key"), with(".pub")];
        for place in &places {
            if std::fs::symlink_metadata(place).is_ok() {
                return Err(Error::new(
                    ErrorKind::Output,
                    "is there already; a key is never replaced",
                )
                .at(place)
                .with_hint("name another pair, or move this one away"));
            }
        }
        create(&places[0], &self.0.sk.to_pem(), 0o600)?;
        create(&places[1], &self.public().to_pem(), 0o666)?;
        Ok(places)
    }

    /// The public key.
    pub fn public(&self) -> VerifyingKey {
        VerifyingKey(self.0.pk)
    }

    /// Signs a statement.
    pub fn sign(&self, statement: &str) -> Signature {
        Signature {
            algorithm: ALGORITHM.to_owned(),
            key: self.public().to_string(),
            value: hexadecimal(self.0.sk.sign(statement, None).as_ref()),
        }
    }
}

impl VerifyingKey {
    /// Reads a public key: SubjectPublicKeyInfo in PEM.
    ///
    /// # Errors
    /// A file that is none.
    pub fn read(path: &Path) -> Result<Self> {
        let text = text(path)?;
        if let Ok(key) = ed25519_compact::PublicKey::from_pem(&text) {
            return Ok(Self(key));
        }
        let what = if text.contains("PRIVATE KEY") {
            "is a private key; verifying takes the public one"
        } else {
            "is no public key of the form Ed25519, PEM"
        };
        Err(Error::new(ErrorKind::Format, what)
            .at(path)
            .with_hint("`proofmass keygen NAME` writes it as NAME.pub"))
    }

    /// The bytes of its file.
    pub fn to_pem(&self) -> String {
        self.0.to_pem()
    }
}

impl Signature {
    /// The key that signed exactly this statement; `None` where the signature is not that of its key.
    pub fn signer(&self, statement: &str) -> Option<VerifyingKey> {
        if self.algorithm != ALGORITHM {
            return None;
        }
        let key = ed25519_compact::PublicKey::from_slice(&bytes(&self.key)?).ok()?;
        let value = ed25519_compact::Signature::from_slice(&bytes(&self.value)?).ok()?;
        key.verify(statement, &value).ok()?;
        Some(VerifyingKey(key))
    }
}

/// A name or path as it stands in a statement: as JSON writes it, so that one line is one entry.
pub(crate) fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

fn bytes(hexadecimal: &str) -> Option<Vec<u8>> {
    let digits = hexadecimal.as_bytes();
    if !digits.len().is_multiple_of(2) {
        return None;
    }
    let value = |d: u8| char::from(d).to_digit(16);
    digits
        .chunks(2)
        .map(|pair| u8::try_from(value(pair[0])? * 16 + value(pair[1])?).ok())
        .collect()
}

fn text(path: &Path) -> Result<String> {
    let (bytes, _) = Source::open(path)?.into_bytes(LARGEST_KEY)?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

fn create(path: &Path, text: &str, mode: u32) -> Result<()> {
    let mut options = std::fs::OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, mode);
    #[cfg(not(unix))]
    let _ = mode;
    options
        .open(path)
        .and_then(|mut file| {
            file.write_all(text.as_bytes())?;
            file.sync_all()
        })
        .map_err(|e| Error::access(path, "write", e))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// **Source** `[RFC8032]` 7.1, test 2.
    #[test]
    fn published_signature_of_one_byte() {
        let seed =
            bytes("4ccd089b28ff96da9db6c346ec114e0f5b8a319f35aba624da8cf6ed4fb8a6fb").unwrap();
        let key = SigningKey(KeyPair::from_seed(Seed::from_slice(&seed).unwrap()));
        assert_eq!(
            key.public().to_string(),
            "3d4017c3e843895a92b70aa74d1b7ebc9c982ccf2ec4968cc0cd55f12af4660c"
        );
        let signature = key.sign("r");
        assert_eq!(
            signature.value,
            "92a009a9f0d4cab8720e820b5f642540a2b27b5416503f8fb3762223ebdb69da\
             085ac1e43e15996e458f3613d0f11d8c387b2eaeb4302aeeb00d291612bb0c00"
        );
        assert_eq!(signature.signer("r"), Some(key.public()));
    }

    #[test]
    fn law_a_signature_is_of_one_statement_and_one_key() {
        let key = SigningKey::generate().unwrap();
        let signature = key.sign("statement");
        assert_eq!(signature.signer("statement"), Some(key.public()));
        assert_eq!(signature.signer("statemenT"), None);
        for place in 0..signature.value.len() {
            let mut wrong = signature.clone();
            let digit = if wrong.value.as_bytes()[place] == b'0' {
                "1"
            } else {
                "0"
            };
            wrong.value.replace_range(place..=place, digit);
            assert_eq!(wrong.signer("statement"), None, "{place}");
        }
        let other = SigningKey::generate().unwrap();
        let mut wrong = signature.clone();
        wrong.key = other.public().to_string();
        assert_eq!(wrong.signer("statement"), None);
        for odd in ["", "0", "zz", "é0"] {
            wrong.key = odd.to_owned();
            assert_eq!(wrong.signer("statement"), None);
        }
        let mut other = signature;
        other.algorithm = "none".to_owned();
        assert_eq!(other.signer("statement"), None);
    }

    #[test]
    fn law_keys_are_read_as_they_were_written() {
        let folder = tempfile::tempdir().unwrap();
        let key = SigningKey::generate().unwrap();
        let [private, public] = key.write(&folder.path().join("lab")).unwrap();
        assert_eq!(SigningKey::read(&private).unwrap().public(), key.public());
        assert_eq!(VerifyingKey::read(&public).unwrap(), key.public());
        // The form of OpenSSL: a fixed head and 32 bytes.
        let pem = std::fs::read_to_string(&private).unwrap();
        assert!(
            pem.starts_with("-----BEGIN PRIVATE KEY-----\nMC4CAQAwBQYDK2VwBCIEI"),
            "{pem}"
        );
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let mode = std::fs::metadata(&private).unwrap().permissions().mode();
            assert_eq!(mode & 0o077, 0, "nobody else may read it");
        }
        let error = key.write(&folder.path().join("lab")).unwrap_err();
        assert!(error.to_string().contains("never replaced"), "{error}");
        // One in the place of the other, and neither.
        assert!(
            SigningKey::read(&public)
                .unwrap_err()
                .to_string()
                .contains("public")
        );
        assert!(
            VerifyingKey::read(&private)
                .unwrap_err()
                .to_string()
                .contains("private")
        );
        assert!(!format!("{key:?}").contains(&pem[64..90]));
        let other = folder.path().join("other");
        std::fs::write(
            &other,
            "-----BEGIN PUBLIC KEY-----\n????\n-----END PUBLIC KEY-----\n",
        )
        .unwrap();
        assert!(VerifyingKey::read(&other).is_err() && SigningKey::read(&other).is_err());
    }
}
