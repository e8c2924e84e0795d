//! Words of a command line, as a shell reads them.

use std::ffi::OsStr;
use std::fmt::Write as _;
use std::path::Path;

/// A path as a shell reads it back, and no command takes it for a flag.
pub(crate) fn quoted(path: &Path) -> String {
    let word = word(path.as_os_str());
    // What begins so lies in this folder.
    if path.as_os_str().as_encoded_bytes().first() == Some(&b'-') {
        return format!("./{word}");
    }
    word
}

/// A text as a shell reads it back.
pub(crate) fn word(text: &OsStr) -> String {
    let is_plain = |byte: &u8| byte.is_ascii_alphanumeric() || b"/._-+".contains(byte);
    let bytes = text.as_encoded_bytes();
    if !bytes.is_empty() && bytes.iter().all(is_plain) {
        return text.to_string_lossy().into_owned();
    }
    let mut word = String::from("'");
    for chunk in bytes.utf8_chunks() {
        word += &chunk.valid().replace('\'', r"'\''");
        // Bytes that no text holds.
        for byte in chunk.invalid() {
            // Writing to a String cannot fail.
            let _ = write!(word, r#"'"$(printf '\{byte:03o}')"'"#);
        }
    }
    word + "'"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_quoted_and_never_flags() {
        for (name, expected) in [
            ("out/a-b.exr", "out/a-b.exr"),
            ("-o", "./-o"),
            ("- o", "./'- o'"),
            ("it's", r"'it'\''s'"),
            ("$(rm x)", "'$(rm x)'"),
            ("", "''"),
        ] {
            assert_eq!(quoted(Path::new(name)), expected);
        }
        assert_eq!(word(OsStr::new("-o")), "-o");
    }

    #[cfg(unix)]
    #[test]
    fn bytes_that_are_no_text_are_printed_by_the_shell() {
        use std::os::unix::ffi::OsStrExt;
        let name = OsStr::from_bytes(b"a\xffb");
        assert_eq!(word(name), r#"'a'"$(printf '\377')"'b'"#);
    }
}
