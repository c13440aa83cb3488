//! What include/catamaran.h declares, from its text.

use std::collections::BTreeMap;

/// A function of the header.
pub struct Function {
    /// The group of the documentation that it is in.
    pub section: String,
    /// Its type, such as `cata_status`.
    pub returns: String,
    /// Its name.
    pub name: String,
    /// Type and name of each, such as `const double *a`.
    pub arguments: Vec<String>,
}

/// A constant of the header.
pub struct Constant {
    /// As [`Function::section`].
    pub section: String,
    /// Its name.
    pub name: String,
    /// Its value, as it is written.
    pub value: String,
}

/// What the header declares, without its comments.
#[derive(Default)]
pub struct Header {
    /// In their order.
    pub functions: Vec<Function>,
    /// In their order.
    pub constants: Vec<Constant>,
    /// Fields of each struct.
    pub structs: BTreeMap<String, Vec<String>>,
}

impl Header {
    /// Returns what a header of the form that `cargo xtask header` writes declares.
    pub fn parse(text: &str) -> Self {
        let mut header = Self::default();
        let (mut section, mut fields) = (String::new(), Vec::new());
        let mut is_comment = false;
        let mut declaration = String::new();
        for line in text.lines() {
            if let Some(group) = line.strip_prefix(" * @defgroup ") {
                section = group.split(' ').next().unwrap_or_default().to_owned();
            }
            let line = line.split(" /**<").next().unwrap_or_default();
            is_comment |= line.trim_start().starts_with("/*");
            if is_comment || line.starts_with('#') {
                if let Some((name, value)) =
                    line.strip_prefix("#define ").and_then(|rest| rest.split_once(' '))
                {
                    let (name, value) = (name.to_owned(), value.to_owned());
                    header.constants.push(Constant { section: section.clone(), name, value });
                }
                is_comment &= !line.contains("*/");
                continue;
            }
            if let Some(name) = line.strip_prefix("} ") {
                let name = name.trim_end_matches(';').to_owned();
                header.structs.insert(name, std::mem::take(&mut fields));
                declaration.clear();
                continue;
            }
            if declaration.is_empty() && line.starts_with("    ") {
                fields.push(line.trim().trim_end_matches(';').to_owned());
                continue;
            }
            declaration += " ";
            declaration += line.trim();
            if declaration.ends_with('{') {
                declaration.clear();
            } else if declaration.ends_with(';') {
                let whole = std::mem::take(&mut declaration);
                header.functions.extend(Function::parse(&section, whole.trim()));
            }
        }
        header
    }
}

impl Function {
    fn parse(section: &str, declaration: &str) -> Option<Self> {
        let declaration = declaration.strip_suffix(");")?;
        if declaration.starts_with("typedef") {
            return None;
        }
        let (head, arguments) = declaration.split_once('(')?;
        let (returns, name) = type_and_name(head);
        Some(Self {
            section: section.to_owned(),
            returns: returns.to_owned(),
            name: name.to_owned(),
            arguments: arguments.split(", ").map(str::to_owned).collect(),
        })
    }
}

/// Splits a declaration such as `const double *a` into `const double *` and `a`.
pub fn type_and_name(declaration: &str) -> (&str, &str) {
    let at = declaration.rfind([' ', '*']).map_or(0, |at| at + 1);
    (declaration[..at].trim(), &declaration[at..])
}

#[cfg(test)]
mod tests {
    use super::Header;

    #[test]
    fn declarations_are_parsed() {
        let text = "/**\n * @defgroup ata A^T A\n */\n#define CATA_K 1 /**< K. */\n/** F(x);\n * \
                    more */\ncata_status cata_f(size_t n,\n    const double *a);\n\
                    typedef struct cata_p {\n    /** n. */\n    size_t n;\n    \
                    int32_t k; /**< k. */\n} cata_p;\nconst char *cata_name(void);\n";
        let header = Header::parse(text);
        let names: Vec<_> = header.functions.iter().map(|f| (&*f.returns, &*f.name)).collect();
        assert_eq!(names, [("cata_status", "cata_f"), ("const char *", "cata_name")]);
        assert_eq!(header.functions[0].section, "ata");
        assert_eq!(header.functions[0].arguments, ["size_t n", "const double *a"]);
        assert_eq!(header.structs["cata_p"], ["size_t n", "int32_t k"]);
        assert_eq!((&*header.constants[0].name, &*header.constants[0].value), ("CATA_K", "1"));
    }
}
