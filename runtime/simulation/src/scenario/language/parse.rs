//! Parser of expressions.

/// Fault of an expression, with its byte in the text.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// Byte of the text.
    pub at: usize,
    /// Description of the fault.
    pub why: String,
}

impl Fault {
    pub(super) fn new<T>(at: usize, why: impl Into<String>) -> Result<T, Self> {
        Err(Self { at, why: why.into() })
    }
}

/// Node of an expression tree.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// First byte of its text.
    pub at: usize,
    /// Kind and children of the node.
    pub tree: Tree,
}

/// Kind and children of a node.
#[derive(Clone, Debug, PartialEq)]
pub enum Tree {
    /// `1.5`, and `true` and `false`.
    Number(f64),
    /// `true` or `false`.
    Truth(bool),
    /// `"bakery"` or `'bakery'`.
    Text(String),
    /// `time`, `me.fatigue`.
    Word(String),
    /// `{ "a", "b" }`.
    Set(Vec<Node>),
    /// `distance(me, other)`.
    Call(String, Vec<Node>),
    /// `-x`, `not x`.
    Unary(&'static str, Box<Node>),
    /// `a < b`.
    Binary(&'static str, Box<Node>, Box<Node>),
}

/// Deepest nesting of an expression.
const DEPTH: usize = 40;
/// Most operators of an expression; each may be a level of the tree, which is walked by recursion.
const OPERATORS: usize = 500;

/// Binary operators by precedence, lowest first.
const LEVELS: [&[&str]; 5] = [&["or"], &["and"], &["==", "!=", "<=", ">=", "<", ">", "in"], &["+", "-"], &["*", "/"]];

/// Parses an expression.
///
/// # Errors
/// [`Fault`] at the first byte that does not fit.
pub fn parse(text: &str) -> Result<Node, Fault> {
    let mut parser = Parser { text, at: 0, depth: 0, operators: 0 };
    let node = parser.level(0)?;
    parser.skip();
    match parser.rest() {
        "" => Ok(node),
        rest => Fault::new(parser.at, format!("expected an operator or the end, found `{}`", first_word(rest))),
    }
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
    depth: usize,
    /// Number of binary operators so far.
    operators: usize,
}

impl<'a> Parser<'a> {
    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    fn skip(&mut self) {
        self.at = self.text.len() - self.rest().trim_start().len();
    }

    /// Consumes a token, if it is the next one; words end where no letter follows.
    fn take(&mut self, token: &str) -> bool {
        self.skip();
        let Some(rest) = self.rest().strip_prefix(token) else { return false };
        let is_word = token.starts_with(|c: char| c.is_ascii_alphabetic());
        if is_word && rest.starts_with(is_of_word) {
            return false;
        }
        self.at += token.len();
        true
    }

    fn level(&mut self, level: usize) -> Result<Node, Fault> {
        self.depth += 1;
        if self.depth > DEPTH * LEVELS.len() {
            return Fault::new(self.at, format!("expected at most {DEPTH} levels of brackets"));
        }
        let Some(operators) = LEVELS.get(level) else {
            let node = self.unary();
            self.depth -= 1;
            return node;
        };
        let mut left = self.level(level + 1)?;
        let mut compared = false;
        while let Some(operator) = operators.iter().find(|o| self.take(o)) {
            if level == 2 && std::mem::replace(&mut compared, true) {
                let why = format!("comparisons do not follow each other: write `a {operator} b and b {operator} c`");
                return Fault::new(self.at, why);
            }
            self.operators += 1;
            if self.operators > OPERATORS {
                return Fault::new(
                    self.at,
                    format!("expected at most {OPERATORS} operators: split it among several rules"),
                );
            }
            let right = self.level(level + 1)?;
            left = Node { at: left.at, tree: Tree::Binary(operator, Box::new(left), Box::new(right)) };
        }
        self.depth -= 1;
        Ok(left)
    }

    fn unary(&mut self) -> Result<Node, Fault> {
        self.skip();
        let at = self.at;
        for operator in ["not", "-"] {
            if self.take(operator) {
                // `not` binds looser than comparisons: `not a == b` is `not (a == b)`.
                let of = self.level(if operator == "not" { 2 } else { LEVELS.len() })?;
                return Ok(Node { at, tree: Tree::Unary(operator, Box::new(of)) });
            }
        }
        self.atom(at)
    }

    fn atom(&mut self, at: usize) -> Result<Node, Fault> {
        let rest = self.rest();
        let tree = match rest.chars().next() {
            None => return Fault::new(at, "expected a value, found the end"),
            Some('(') => {
                self.at += 1;
                let inner = self.level(0)?;
                self.close(")")?;
                return Ok(inner);
            }
            Some('{') => {
                self.at += 1;
                Tree::Set(self.list("}")?)
            }
            Some(quote @ ('"' | '\'')) => {
                let Some(end) = rest[1..].find(quote) else {
                    return Fault::new(at, format!("expected a closing {quote}, found the end"));
                };
                self.at += end + 2;
                Tree::Text(rest[1..=end].into())
            }
            Some(c) if c.is_ascii_digit() || c == '.' => {
                let end = rest.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(rest.len());
                self.at += end;
                match rest[..end].parse() {
                    Ok(number) => Tree::Number(number),
                    Err(_) => return Fault::new(at, format!("expected a number, found `{}`", &rest[..end])),
                }
            }
            Some(c) if c.is_ascii_alphabetic() => {
                let end = rest.find(|c| !is_of_word(c)).unwrap_or(rest.len());
                self.at += end;
                match &rest[..end] {
                    "true" => Tree::Truth(true),
                    "false" => Tree::Truth(false),
                    word if self.take("(") => Tree::Call(word.into(), self.list(")")?),
                    word => Tree::Word(word.into()),
                }
            }
            Some(c) => return Fault::new(at, format!("expected a value, found `{c}`")),
        };
        Ok(Node { at, tree })
    }

    /// Parses expressions between commas, up to a closing bracket.
    fn list(&mut self, end: &str) -> Result<Vec<Node>, Fault> {
        let mut out = Vec::new();
        if self.take(end) {
            return Ok(out);
        }
        loop {
            out.push(self.level(0)?);
            if !self.take(",") {
                self.close(end)?;
                return Ok(out);
            }
        }
    }

    fn close(&mut self, end: &str) -> Result<(), Fault> {
        if self.take(end) {
            return Ok(());
        }
        let found = if self.rest().is_empty() { "the end".into() } else { format!("`{}`", first_word(self.rest())) };
        Fault::new(self.at, format!("expected `{end}`, found {found}"))
    }
}

fn is_of_word(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_' || c == '.'
}

/// The first word of a text, or its first character.
fn first_word(text: &str) -> &str {
    let end = text.find(|c| !is_of_word(c)).unwrap_or(text.len());
    if end > 0 { &text[..end] } else { text.split_at(text.chars().next().map_or(0, char::len_utf8)).0 }
}
