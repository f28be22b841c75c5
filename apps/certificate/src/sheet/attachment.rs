//! Files that travel inside the certificate.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use super::Reader;
use super::text::filled;
use crate::error::Result;
use crate::place::Place;

impl Reader {
    pub(super) fn attachment(&mut self, attachment: &Place) -> Result<()> {
        attachment.only(&[
            "name",
            "media_type",
            "relationship",
            "description",
            "base64",
        ])?;
        let name = attachment.member("name")?;
        let plain = |c: char| !c.is_control() && !matches!(c, '/' | '\\' | ':');
        if name.text()?.is_empty()
            || name.text()?.starts_with('.')
            || !name.text()?.chars().all(plain)
        {
            return Err(name.error(
                format!("\"{}\" is no name of a file", name.text()?.escape_debug()),
                "use a name without folders, as result.json",
            ));
        }
        if !self.names.insert(name.text()?.to_owned()) {
            return Err(name.error(
                format!(
                    "the name \"{}\" is taken by another attachment",
                    name.text()?
                ),
                "give each attachment a name of its own",
            ));
        }
        let media_type = attachment.member("media_type")?;
        let word = |w: &str| {
            !w.is_empty()
                && w.bytes()
                    .all(|b| b.is_ascii_alphanumeric() || b"!#$&^_.+-".contains(&b))
        };
        if !media_type
            .text()?
            .split_once('/')
            .is_some_and(|(a, b)| word(a) && word(b))
        {
            return Err(media_type.error(
                format!("\"{}\" is no media type", media_type.text()?.escape_debug()),
                "write it as application/json",
            ));
        }
        attachment
            .member("relationship")?
            .one_of(&["Alternative", "Data", "Source"])?;
        filled(&attachment.member("description")?)?;
        let base64 = attachment.member("base64")?;
        let bytes = STANDARD.decode(base64.text()?).map_err(|e| {
            base64.error(
                format!("the attachment is not base64: {e}"),
                "encode the bytes of the file with the standard alphabet and padding, without line breaks",
            )
        })?;
        self.file(
            &base64,
            format!("attachment-{}", self.files.len()),
            bytes,
            false,
        );
        Ok(())
    }
}
