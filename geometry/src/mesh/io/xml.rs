//! The parts of XML 1.0 that mesh files use: elements with attributes, text, comments and CDATA.
//! Definitions of entities are skipped, so that none can grow.

use std::borrow::Cow;

use super::cursor::Cursor;
use super::draft::Checked;
use super::text::quoted;
use catamaran::base::push;

/// The next part of a document.
pub(super) enum Event<'a> {
    Start(Tag<'a>),
    /// The end of the element that began last, also where it is empty.
    End(&'a [u8]),
    Text(&'a [u8]),
}

/// The start of an element. Names are without prefixes of name spaces.
pub(super) struct Tag<'a> {
    pub name: &'a [u8],
    attributes: Vec<(&'a [u8], &'a [u8])>,
}

impl<'a> Tag<'a> {
    /// Returns the value of an attribute.
    pub fn get(&self, name: &str) -> Option<Cow<'a, str>> {
        self.raw(name).map(unescaped)
    }

    /// Returns the value of an attribute, or an error that names the attribute.
    pub fn need(&self, name: &str) -> Checked<Cow<'a, str>> {
        Ok(self.raw(name).map(unescaped).ok_or_else(|| self.lacks(name))?)
    }

    /// Returns the value of an attribute that is a number or a name, as bytes.
    pub fn bytes(&self, name: &str) -> Checked<&'a [u8]> {
        Ok(self.raw(name).ok_or_else(|| self.lacks(name))?.trim_ascii())
    }

    fn raw(&self, name: &str) -> Option<&'a [u8]> {
        let found = self.attributes.iter().find(|(key, _)| *key == name.as_bytes());
        found.map(|(_, value)| *value)
    }

    fn lacks(&self, name: &str) -> String {
        format!("<{}> has no attribute {name}", String::from_utf8_lossy(self.name))
    }
}

/// Reads a document part by part.
pub(super) struct Xml<'a> {
    pub cursor: Cursor<'a>,
    open: Vec<&'a [u8]>,
    /// Whether the element that began last is empty.
    is_empty: bool,
}

impl<'a> Xml<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { cursor: Cursor::new(bytes), open: Vec::new(), is_empty: false }
    }

    /// Returns the names of the elements that have begun and not ended, the outermost first.
    pub fn open(&self) -> &[&'a [u8]] {
        &self.open
    }

    /// Returns the next part; `None` at the end of the document.
    pub fn next(&mut self) -> Checked<Option<Event<'a>>> {
        if std::mem::take(&mut self.is_empty) {
            return Ok(self.open.pop().map(Event::End));
        }
        loop {
            let rest = self.cursor.rest();
            let text = rest.iter().position(|&byte| byte == b'<').unwrap_or(rest.len());
            if text > 0 {
                return Ok(Some(Event::Text(self.cursor.skip(text))));
            }
            if rest.is_empty() {
                return match self.open.last() {
                    None => Ok(None),
                    Some(name) => {
                        Err(format!("truncated: the file ends before </{}>", shown(name)).into())
                    }
                };
            }
            if rest.starts_with(b"<!--") {
                self.until(4, b"-->")?;
            } else if rest.starts_with(b"<![CDATA[") {
                return Ok(Some(Event::Text(self.until(9, b"]]>")?)));
            } else if rest.starts_with(b"<?") {
                self.until(2, b"?>")?;
            } else if rest.starts_with(b"<!") {
                let mut start = rest.iter().take_while(|&&byte| byte != b'>');
                if start.any(|&byte| byte == b'[') {
                    self.until(2, b"]")?;
                }
                self.until(0, b">")?;
            } else if rest.starts_with(b"</") {
                let name = local(self.until(2, b">")?.trim_ascii());
                return match self.open.pop() {
                    Some(open) if open == name => Ok(Some(Event::End(name))),
                    Some(open) => {
                        Err(format!("</{}> where <{}> is open", shown(name), shown(open)).into())
                    }
                    None => Err(format!("</{}> without a start", shown(name)).into()),
                };
            } else {
                return self.tag().map(|tag| Some(Event::Start(tag)));
            }
        }
    }

    /// Skips `before` bytes, and takes what comes before `end`, and `end`.
    fn until(&mut self, before: usize, end: &'static [u8]) -> Checked<&'a [u8]> {
        self.cursor.skip(before);
        let rest = self.cursor.rest();
        let Some(length) = rest.windows(end.len()).position(|bytes| bytes == end) else {
            let what = format!("truncated: the file ends before {}", shown(end));
            return Err(what.into());
        };
        Ok(&self.cursor.skip(length + end.len())[..length])
    }

    fn tag(&mut self) -> Checked<Tag<'a>> {
        self.cursor.skip(1);
        let name = self.name()?;
        let mut attributes = Vec::new();
        loop {
            self.blanks();
            let rest = self.cursor.rest();
            if rest.starts_with(b">") {
                self.cursor.skip(1);
                break;
            }
            if rest.starts_with(b"/>") {
                self.cursor.skip(2);
                self.is_empty = true;
                break;
            }
            let key = self.name()?;
            self.blanks();
            if self.cursor.skip(1) != b"=" {
                return Err(format!("attribute {} without a value", quoted(key)).into());
            }
            self.blanks();
            let value = match self.cursor.rest().first() {
                Some(b'"') => self.until(1, b"\"")?,
                Some(b'\'') => self.until(1, b"'")?,
                _ => return Err(format!("the value of {} has no quotes", quoted(key)).into()),
            };
            push(&mut attributes, (key, value))?;
        }
        push(&mut self.open, name)?;
        Ok(Tag { name, attributes })
    }

    fn blanks(&mut self) {
        let rest = self.cursor.rest();
        self.cursor.skip(rest.len() - rest.trim_ascii_start().len());
    }

    /// Takes the name of an element or an attribute.
    fn name(&mut self) -> Checked<&'a [u8]> {
        let is_name = |byte: &&u8| !byte.is_ascii_whitespace() && !b"=/<>\"'".contains(byte);
        let length = self.cursor.rest().iter().take_while(is_name).count();
        if length == 0 {
            return Err("a name is missing in a tag".into());
        }
        Ok(local(self.cursor.skip(length)))
    }
}

/// Returns a name without the prefix of its name space.
fn local(name: &[u8]) -> &[u8] {
    name.rsplit(|&byte| byte == b':').next().unwrap_or(name)
}

fn shown(name: &[u8]) -> String {
    String::from_utf8_lossy(name).into_owned()
}

/// Returns text with characters in place of `&lt;`, `&#60;` and the like.
pub(super) fn unescaped(text: &[u8]) -> Cow<'_, str> {
    let text = String::from_utf8_lossy(text);
    if !text.contains('&') {
        return text;
    }
    let mut pieces = text.split('&');
    let mut plain = String::from(pieces.next().unwrap_or_default());
    for piece in pieces {
        let (entity, after) = piece.split_once(';').unwrap_or(("", piece));
        let code = |digits: &str| match digits.strip_prefix('x') {
            Some(digits) => u32::from_str_radix(digits, 16).ok(),
            None => digits.parse().ok(),
        };
        let character = match entity {
            "lt" => Some('<'),
            "gt" => Some('>'),
            "amp" => Some('&'),
            "quot" => Some('"'),
            "apos" => Some('\''),
            _ => entity.strip_prefix('#').and_then(code).and_then(char::from_u32),
        };
        match character {
            Some(character) => {
                plain.push(character);
                plain.push_str(after);
            }
            None => {
                plain.push('&');
                plain.push_str(piece);
            }
        }
    }
    plain.into()
}

/// Returns text as it stands in an attribute or an element.
pub(super) fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '&' => safe.push_str("&amp;"),
            '"' => safe.push_str("&quot;"),
            other if other.is_control() => safe.push(' '),
            other => safe.push(other),
        }
    }
    safe
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the parts of a document, or what is wrong with it.
    fn parts(text: &str) -> Result<Vec<String>, String> {
        let mut xml = Xml::new(text.as_bytes());
        let mut parts = Vec::new();
        loop {
            match xml.next() {
                Ok(None) => return Ok(parts),
                Ok(Some(Event::Start(tag))) => {
                    let value = tag.get("a").map(|value| format!(" {value}")).unwrap_or_default();
                    parts.push(format!("<{}{value}>", shown(tag.name)));
                }
                Ok(Some(Event::End(name))) => parts.push(format!("</{}>", shown(name))),
                Ok(Some(Event::Text(text))) => parts.push(unescaped(text).into_owned()),
                Err(crate::mesh::io::draft::Fault::What(what)) => return Err(what),
                Err(_) => return Err("memory".into()),
            }
        }
    }

    #[test]
    fn elements_text_and_entities_are_read() {
        let text = "<?xml version='1.0'?><!DOCTYPE x [<!ENTITY b \"c\">] ><!-- <no> -->\
                    <n:x a = '&lt;&#65;&#x42;&b;' c=\"1\"><y/>1 &amp; 2<![CDATA[<&]]></n:x>";
        let expected = ["<x <AB&b;>", "<y>", "</y>", "1 & 2", "<&", "</x>"];
        assert_eq!(parts(text).unwrap(), expected);
        assert_eq!(unescaped(escaped("a<b>&\"c").as_bytes()), "a<b>&\"c");
    }

    #[test]
    fn broken_documents_are_refused() {
        for (text, what) in [
            ("<a>", "truncated: the file ends before </a>"),
            ("<a", "a name is missing"),
            ("<a b>", "without a value"),
            ("<a b=c>", "has no quotes"),
            ("<a b='c>", "truncated: the file ends before '"),
            ("</a>", "without a start"),
            ("<a></b>", "</b> where <a> is open"),
            ("<!-- ", "truncated"),
        ] {
            let refused = parts(text).unwrap_err();
            assert!(refused.contains(what), "{text}: {refused}");
        }
    }
}
