//! What one Rust file says about its imports.

use proc_macro2::{Delimiter, TokenStream, TokenTree};

/// A word, a piece of punctuation (`::` is one), or a literal (an empty text).
#[derive(Debug, Clone, PartialEq, Eq)]
struct Token {
    text: String,
    line: usize,
}

/// A path in the code, such as `super::shapes::Circle`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Reference {
    pub path: Vec<String>,
    pub line: usize,
}

/// One name that a `use` declaration brings in.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Import {
    /// The whole path; of `a::*` that of `a`.
    pub path: Vec<String>,
    /// The name it gets here, `*` for all that the path holds.
    pub name: String,
    /// Whether it is handed on (`pub`).
    pub public: bool,
    pub line: usize,
}

/// The content of a file; tests are left out.
#[derive(Debug, Default)]
pub struct Source {
    pub imports: Vec<Import>,
    /// Paths of two names or more outside of `use` declarations.
    pub references: Vec<Reference>,
    /// All names outside of `use` declarations.
    pub words: Vec<Reference>,
    /// Child modules in files of their own.
    pub children: Vec<String>,
    /// Items that the file itself defines.
    pub defined: Vec<String>,
}

impl Source {
    pub fn parse(text: &str) -> Self {
        let mut tokens = Vec::new();
        flatten(text.parse().expect("Rust"), &mut tokens);
        let tokens = without_tests(&tokens);
        let mut source = Self::default();
        // Braces of the inline modules that the position is in: `super` there is this file.
        let (mut depth, mut inline) = (0, Vec::new());
        let mut at = 0;
        while let Some(token) = tokens.get(at) {
            let word = |i: usize| tokens.get(i).map_or("", |t| t.text.as_str());
            let public = at > 0 && (word(at - 1) == "pub" || is_restricted_pub(&tokens[..at]));
            match token.text.as_str() {
                "{" => depth += 1,
                "}" => {
                    depth -= 1;
                    inline.retain(|&d| d < depth);
                }
                "mod" if word(at + 2) == ";" => {
                    source.children.push(word(at + 1).into());
                    at += 2;
                }
                "mod" => {
                    source.defined.push(word(at + 1).into());
                    inline.push(depth);
                    at += 1;
                }
                // Not the `use<'a>` of a return type.
                "use" if word(at + 1) != "<" => {
                    let end = at + tokens[at..].iter().position(|t| t.text == ";").unwrap();
                    let mut leaves = Vec::new();
                    tree(&tokens[at + 1..end], &mut Vec::new(), &mut leaves);
                    for (path, name, line) in leaves {
                        let Some(path) = leave(path, inline.len()) else { continue };
                        source.imports.push(Import { path, name, public, line });
                    }
                    at = end;
                }
                text if is_word(text) => {
                    let start = at;
                    let mut path = vec![text.to_owned()];
                    while word(at + 1) == "::" && is_word(word(at + 2)) {
                        path.push(word(at + 2).into());
                        at += 2;
                    }
                    let before = if start > 0 { word(start - 1) } else { "" };
                    if matches!(
                        before,
                        "fn" | "struct" | "enum" | "union" | "trait" | "type" | "const" | "static"
                    ) || start > 1 && before == "!" && word(start - 2) == "macro_rules"
                    {
                        source.defined.push(path[0].clone());
                    }
                    // After a dot it is a field or a method, after `::` a rest.
                    let starts = before != "." && before != "::";
                    if let Some(path) = leave(path, inline.len()).filter(|_| starts) {
                        source
                            .words
                            .push(Reference { path: vec![path[0].clone()], line: token.line });
                        if path.len() > 1 {
                            source.references.push(Reference { path, line: token.line });
                        }
                    }
                }
                _ => {}
            }
            at += 1;
        }
        source
    }
}

/// `path` as seen from the file, where the code is in inline modules, `depth` deep; none when it
/// stays in these.
fn leave(mut path: Vec<String>, depth: usize) -> Option<Vec<String>> {
    for _ in 0..depth {
        match path[0].as_str() {
            "super" => path.remove(0),
            "self" => return None,
            _ => break,
        };
        if path.first().is_none_or(|first| first != "super") {
            path.insert(0, "self".into());
        }
    }
    Some(path)
}

/// Whether the tokens end in `pub(...)`.
fn is_restricted_pub(tokens: &[Token]) -> bool {
    tokens.last().is_some_and(|t| t.text == ")")
        && tokens
            .iter()
            .rposition(|t| t.text == "(")
            .is_some_and(|open| open > 0 && tokens[open - 1].text == "pub")
}

fn is_word(text: &str) -> bool {
    text.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// The names that the tree of a `use` declaration brings in: path, name, line.
fn tree(tokens: &[Token], prefix: &mut Vec<String>, found: &mut Vec<(Vec<String>, String, usize)>) {
    let (mut start, mut depth) = (0, 0);
    for end in 0..=tokens.len() {
        match tokens.get(end).map(|t| t.text.as_str()) {
            Some("{") => depth += 1,
            Some("}") => depth -= 1,
            Some(",") if depth == 0 => {}
            None => {}
            _ => continue,
        }
        let is_end = tokens.get(end).is_none_or(|t| t.text == ",") && depth == 0;
        if is_end {
            branch(&tokens[start..end], prefix, found);
            start = end + 1;
        }
    }
}

/// One branch of a `use` tree: `a::b`, `a as b`, `a::*`, `a::{...}`.
fn branch(
    tokens: &[Token],
    prefix: &mut Vec<String>,
    found: &mut Vec<(Vec<String>, String, usize)>,
) {
    let length = prefix.len();
    let mut at = 0;
    while let Some(token) = tokens.get(at) {
        match token.text.as_str() {
            "{" => {
                tree(&tokens[at + 1..tokens.len() - 1], prefix, found);
                prefix.truncate(length);
                return;
            }
            "*" => {
                found.push((prefix.clone(), "*".into(), token.line));
                prefix.truncate(length);
                return;
            }
            "as" => break,
            // `a::{self}` is `a`.
            "self" if !prefix.is_empty() => {}
            text if is_word(text) => prefix.push(text.into()),
            _ => {}
        }
        at += 1;
    }
    if let (Some(last), Some(first)) = (prefix.last(), tokens.first()) {
        let name = tokens.get(at + 1).map_or(last.clone(), |alias| alias.text.clone());
        found.push((prefix.clone(), name, first.line));
    }
    prefix.truncate(length);
}

/// Adds the tokens of a stream, those in brackets too; comments are left out.
fn flatten(stream: TokenStream, found: &mut Vec<Token>) {
    for tree in stream {
        let line = tree.span().start().line;
        match tree {
            TokenTree::Ident(word) => found.push(Token { text: word.to_string(), line }),
            TokenTree::Literal(_) => found.push(Token { text: String::new(), line }),
            TokenTree::Punct(mark) => match found.last_mut() {
                Some(last) if mark.as_char() == ':' && last.text == ":" => last.text = "::".into(),
                _ => found.push(Token { text: mark.as_char().into(), line }),
            },
            TokenTree::Group(group) => {
                let (open, close) = match group.delimiter() {
                    Delimiter::Parenthesis => ("(", ")"),
                    Delimiter::Brace => ("{", "}"),
                    Delimiter::Bracket => ("[", "]"),
                    Delimiter::None => ("", ""),
                };
                found.push(Token { text: open.into(), line });
                flatten(group.stream(), found);
                found.push(Token { text: close.into(), line: group.span_close().end().line });
            }
        }
    }
}

/// The tokens without attributes, and without the items whose attribute says that they are for
/// tests.
fn without_tests(tokens: &[Token]) -> Vec<Token> {
    let mut kept = Vec::new();
    let (mut at, mut is_test) = (0, false);
    while at < tokens.len() {
        let is = |i: usize, text: &str| tokens.get(i).is_some_and(|t| t.text == text);
        if is(at, "#") && (is(at + 1, "[") || is(at + 1, "!") && is(at + 2, "[")) {
            let open = if is(at + 1, "[") { at + 1 } else { at + 2 };
            let end = closing(tokens, open);
            let words: Vec<_> = tokens[open..end].iter().map(|t| t.text.as_str()).collect();
            is_test |= words.get(1) == Some(&"cfg")
                && (words.get(3) == Some(&"test")
                    || words.get(3..6) == Some(&["all", "(", "test"]));
            at = end + 1;
        } else if is_test {
            at = end_of_item(tokens, at);
            is_test = false;
        } else {
            kept.push(tokens[at].clone());
            at += 1;
        }
    }
    kept
}

/// The position of the bracket that closes the one at `open`.
fn closing(tokens: &[Token], open: usize) -> usize {
    let mut depth = 0;
    for (at, token) in tokens.iter().enumerate().skip(open) {
        match token.text.as_str() {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return at;
        }
    }
    tokens.len()
}

/// The position after the item that starts at `at`: it ends in a semicolon, or with its body.
fn end_of_item(tokens: &[Token], mut at: usize) -> usize {
    let mut is_use = false;
    while let Some(token) = tokens.get(at) {
        match token.text.as_str() {
            "use" => is_use = true,
            ";" => return at + 1,
            "(" | "[" => at = closing(tokens, at),
            "{" if is_use => at = closing(tokens, at),
            "{" => return closing(tokens, at) + 1,
            _ => {}
        }
        at += 1;
    }
    at
}
