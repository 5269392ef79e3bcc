//! Reads words and numbers from the bytes of a text file, with the line and column of each.
//!
//! Line ends are LF, CRLF or CR; a byte-order mark is skipped. Nothing is allocated but error messages.

use super::source::content_error;
use crate::ImportError;
use std::path::Path;

/// Largest magnitude accepted as a number of a motion file; anything above is a damaged file, and sums of a few
/// thousand of these are still finite in `f32`.
const MAX_NUMBER: f64 = 1e9;
/// Advice for a decimal comma.
const HELP_COMMA: &str =
    "Decimals follow a point, not a comma: export the clip again with the language of the program set to English.";

/// A position in the text.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TextPosition {
    pos: usize,
    line: usize,
    line_start: usize,
}

/// A cursor over the bytes of a text file.
pub(crate) struct Scanner<'a> {
    /// The text.
    pub bytes: &'a [u8],
    /// The file, for errors.
    pub path: &'a Path,
    at: TextPosition,
}

impl<'a> Scanner<'a> {
    /// Starts at the first byte that is not a byte-order mark.
    ///
    /// # Errors
    /// [`ImportError::Content`] for UTF-16 text.
    pub fn new(bytes: &'a [u8], path: &'a Path) -> Result<Self, ImportError> {
        if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
            return Err(content_error(path, "the text is UTF-16", "Save the file as UTF-8 or ASCII"));
        }
        let pos = if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        Ok(Self { bytes, path, at: TextPosition { pos, line: 1, line_start: pos } })
    }

    /// Position of the cursor.
    pub fn position(&self) -> TextPosition {
        self.at
    }

    /// Position of the next word of this line, or of the line's end, where the cursor then is.
    pub fn next_position(&mut self) -> TextPosition {
        self.at_line_end();
        self.at
    }

    /// Another cursor, at an earlier position.
    pub fn cursor_at(&self, mark: TextPosition) -> Self {
        Self { bytes: self.bytes, path: self.path, at: mark }
    }

    /// Goes back to an earlier position.
    pub fn rewind(&mut self, mark: TextPosition) {
        self.at = mark;
    }

    fn peek(&self) -> Option<u8> {
        self.bytes.get(self.at.pos).copied()
    }

    /// True at the end of the file.
    pub fn at_end(&self) -> bool {
        self.at.pos >= self.bytes.len()
    }

    /// Skips blanks within the line; true when the line or file ends here.
    pub fn at_line_end(&mut self) -> bool {
        while matches!(self.peek(), Some(b' ' | b'\t' | 0x0b | 0x0c)) {
            self.at.pos += 1;
        }
        matches!(self.peek(), None | Some(b'\n' | b'\r'))
    }

    /// Goes to the start of the next line.
    pub fn next_line(&mut self) {
        while !matches!(self.peek(), None | Some(b'\n' | b'\r')) {
            self.at.pos += 1;
        }
        self.newline();
    }

    fn newline(&mut self) {
        match self.peek() {
            Some(b'\r') if self.bytes.get(self.at.pos + 1) == Some(&b'\n') => self.at.pos += 2,
            Some(b'\r' | b'\n') => self.at.pos += 1,
            _ => return,
        }
        self.at.line += 1;
        self.at.line_start = self.at.pos;
    }

    /// Skips blanks and line ends; false at the end of the file.
    pub fn skip_space(&mut self) -> bool {
        while self.at_line_end() && !self.at_end() {
            self.newline();
        }
        !self.at_end()
    }

    /// The next word of this line; `None` where the line has no more. Braces are words of their own.
    pub fn word(&mut self) -> Option<&'a [u8]> {
        if self.at_line_end() {
            return None;
        }
        let start = self.at.pos;
        self.at.pos += 1;
        if !matches!(self.bytes[start], b'{' | b'}') {
            while !matches!(self.peek(), None | Some(b' ' | b'\t' | 0x0b | 0x0c | b'\n' | b'\r' | b'{' | b'}')) {
                self.at.pos += 1;
            }
        }
        Some(&self.bytes[start..self.at.pos])
    }

    /// The rest of the line up to an opening brace, without blanks at its ends.
    pub fn name(&mut self) -> &'a [u8] {
        if self.at_line_end() {
            return &[];
        }
        let start = self.at.pos;
        while !matches!(self.peek(), None | Some(b'\n' | b'\r' | b'{')) {
            self.at.pos += 1;
        }
        self.bytes[start..self.at.pos].trim_ascii_end()
    }

    /// Steps over `keyword` (any case) if it stands here; line ends before it are skipped.
    pub fn take_keyword(&mut self, keyword: &str) -> bool {
        self.skip_space();
        let end = self.at.pos + keyword.len();
        let hit = self.bytes.get(self.at.pos..end).is_some_and(|b| b.eq_ignore_ascii_case(keyword.as_bytes()));
        if hit {
            self.at.pos = end;
        }
        hit
    }

    /// Steps over `keyword`, or returns an error that it is missing.
    pub fn expect(&mut self, keyword: &str, help: &str) -> Result<(), ImportError> {
        if self.take_keyword(keyword) { Ok(()) } else { Err(self.error(self.at, &format!("`{keyword}`"), help)) }
    }

    /// A finite number on this line.
    pub fn number(&mut self, expected: &str, help: &str) -> Result<f64, ImportError> {
        let mark = self.next_position();
        let word = self.word();
        let value = word.and_then(parse_number).filter(|v| v.abs() <= MAX_NUMBER);
        let has_comma = word.is_some_and(|w| w.contains(&b',') && w.iter().all(|c| b"+-.,eE0123456789".contains(c)));
        let help = if has_comma { HELP_COMMA } else { help };
        value.ok_or_else(|| self.error(mark, expected, help))
    }

    /// A whole number that counts something.
    pub fn count(&mut self, expected: &str, help: &str) -> Result<u64, ImportError> {
        let mark = self.next_position();
        let value = self.word().and_then(parse_count);
        value.ok_or_else(|| self.error(mark, expected, help))
    }

    /// Fails unless the line ends here.
    pub fn expect_line_end(&mut self, expected: &str, help: &str) -> Result<(), ImportError> {
        if self.at_line_end() { Ok(()) } else { Err(self.error(self.at, expected, help)) }
    }

    /// An error about the text at `mark`.
    pub fn error(&self, mark: TextPosition, expected: &str, help: &str) -> ImportError {
        self.error_found(mark, expected, &self.describe(mark), help)
    }

    /// An error at `mark` whose finding the caller words.
    pub fn error_found(&self, mark: TextPosition, expected: &str, found: &str, help: &str) -> ImportError {
        let before = &self.bytes[mark.line_start..mark.pos.max(mark.line_start)];
        ImportError::Syntax {
            path: self.path.to_owned(),
            line: mark.line,
            column: text(before).chars().count() + 1,
            expected: expected.into(),
            found: found.into(),
            help: help.into(),
        }
    }

    fn describe(&self, mark: TextPosition) -> String {
        let mut here = self.cursor_at(mark);
        let Some(word) = here.word() else {
            return if here.at_end() { "the end of the file".into() } else { "the end of the line".into() };
        };
        let shown: String =
            text(&word[..word.len().min(40)]).chars().map(|c| if c.is_control() { '?' } else { c }).collect();
        format!("`{shown}{}`", if word.len() > 40 { "..." } else { "" })
    }
}

/// A finite decimal number; `None` for anything else, infinities and NaN included.
fn parse_number(word: &[u8]) -> Option<f64> {
    let s = std::str::from_utf8(word).ok()?;
    s.parse().ok().filter(|v: &f64| v.is_finite())
}

/// A whole number of at least 0.
pub(crate) fn parse_count(word: &[u8]) -> Option<u64> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// Text of names and messages: UTF-8, or Latin-1 where it is not.
pub(crate) fn text(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(s) => s.to_owned(),
        Err(_) => bytes.iter().map(|&b| char::from(b)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scanner(bytes: &[u8]) -> Scanner<'_> {
        Scanner::new(bytes, Path::new("a.txt")).unwrap()
    }

    #[test]
    fn lines_end_with_lf_crlf_or_cr() {
        let mut s = scanner(b"\xef\xbb\xbfone\r\ntwo\rthree\n\nfive");
        let mut lines = Vec::new();
        while s.skip_space() {
            lines.push((s.position().line, text(s.word().unwrap())));
        }
        let words = lines.iter().map(|(l, w)| (*l, w.as_str())).collect::<Vec<_>>();
        assert_eq!(words, [(1, "one"), (2, "two"), (3, "three"), (5, "five")]);
    }

    #[test]
    fn errors_count_columns_in_characters_and_name_what_stands_there() {
        let mut s = scanner("\u{e9}\u{e9} 1.5 nan".as_bytes());
        s.word();
        assert_eq!(s.number("a number", "").unwrap(), 1.5);
        let e = s.number("a number", "Fix it.").unwrap_err().to_string();
        assert_eq!(e, "a.txt:1:8: expected a number, found `nan`. Fix it.");
    }

    #[test]
    fn numbers_are_finite_and_of_sensible_size() {
        for (word, ok) in
            [("1.2e-014", true), ("-0", true), ("+3", true), ("1e10", false), ("inf", false), ("1,5", false)]
        {
            assert_eq!(scanner(word.as_bytes()).number("x", "").is_ok(), ok, "{word}");
        }
        let why = scanner(b"0,135").number("x", "help").unwrap_err().to_string();
        assert!(why.contains("comma"), "{why}");
    }
}
