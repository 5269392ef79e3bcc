//! Parser of expressions.

/// Fault of an expression, with its byte in the text.
#[derive(Clone, Debug, PartialEq)]
pub struct ExpressionFault {
    /// Byte of the text.
    pub at: usize,
    /// Description of the fault.
    pub why: String,
}

impl ExpressionFault {
    pub(super) fn new<T>(at: usize, why: impl Into<String>) -> Result<T, Self> {
        Err(Self { at, why: why.into() })
    }
}

/// Node of an expression tree.
#[derive(Clone, Debug, PartialEq)]
pub struct ExpressionNode {
    /// First byte of its text.
    pub at: usize,
    /// Kind and children of the node.
    pub tree: ExpressionTree,
}

/// Kind and children of a node.
#[derive(Clone, Debug, PartialEq)]
pub enum ExpressionTree {
    /// `1.5`, and `true` and `false`.
    Number(f64),
    /// `true` or `false`.
    Truth(bool),
    /// `"bakery"` or `'bakery'`.
    Text(String),
    /// `time`, `me.fatigue`.
    Word(String),
    /// `{ "a", "b" }`.
    Set(Vec<ExpressionNode>),
    /// `distance(me, other)`.
    Call(String, Vec<ExpressionNode>),
    /// `-x`, `not x`.
    Unary(&'static str, Box<ExpressionNode>),
    /// `a < b`.
    Binary(&'static str, Box<ExpressionNode>, Box<ExpressionNode>),
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
/// [`ExpressionFault`] at the first byte that does not fit.
pub fn parse_expression(text: &str) -> Result<ExpressionNode, ExpressionFault> {
    let mut parser = Parser { text, at: 0, depth: 0, operators: 0 };
    let node = parser.parse_level(0)?;
    parser.skip_blanks();
    if parser.rest().is_empty() {
        return Ok(node);
    }
    let found = first_word(parser.rest());
    ExpressionFault::new(parser.at, format!("expected an operator or the end, found `{found}`"))
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

    fn skip_blanks(&mut self) {
        self.at = self.text.len() - self.rest().trim_start().len();
    }

    /// Consumes a token, if it is the next one; words end where no letter follows.
    fn take_token(&mut self, token: &str) -> bool {
        self.skip_blanks();
        let Some(rest) = self.rest().strip_prefix(token) else { return false };
        let is_word = token.starts_with(|c: char| c.is_ascii_alphabetic());
        if is_word && rest.starts_with(is_of_word) {
            return false;
        }
        self.at += token.len();
        true
    }

    fn parse_level(&mut self, level: usize) -> Result<ExpressionNode, ExpressionFault> {
        self.depth += 1;
        if self.depth > DEPTH * LEVELS.len() {
            return ExpressionFault::new(self.at, format!("expected at most {DEPTH} levels of brackets"));
        }
        let Some(operators) = LEVELS.get(level) else {
            let node = self.parse_unary();
            self.depth -= 1;
            return node;
        };
        let mut left = self.parse_level(level + 1)?;
        let mut compared = false;
        while let Some(operator) = operators.iter().find(|o| self.take_token(o)) {
            if level == 2 && std::mem::replace(&mut compared, true) {
                let why = format!("comparisons do not follow each other: write `a {operator} b and b {operator} c`");
                return ExpressionFault::new(self.at, why);
            }
            self.operators += 1;
            if self.operators > OPERATORS {
                let why = format!("expected at most {OPERATORS} operators: split it among several rules");
                return ExpressionFault::new(self.at, why);
            }
            let right = self.parse_level(level + 1)?;
            let at = left.at;
            left = ExpressionNode { at, tree: ExpressionTree::Binary(operator, Box::new(left), Box::new(right)) };
        }
        self.depth -= 1;
        Ok(left)
    }

    fn parse_unary(&mut self) -> Result<ExpressionNode, ExpressionFault> {
        self.skip_blanks();
        let at = self.at;
        for operator in ["not", "-"] {
            if self.take_token(operator) {
                // `not` binds looser than comparisons: `not a == b` is `not (a == b)`.
                let of = self.parse_level(if operator == "not" { 2 } else { LEVELS.len() })?;
                return Ok(ExpressionNode { at, tree: ExpressionTree::Unary(operator, Box::new(of)) });
            }
        }
        self.parse_atom(at)
    }

    fn parse_atom(&mut self, at: usize) -> Result<ExpressionNode, ExpressionFault> {
        let rest = self.rest();
        let tree = match rest.chars().next() {
            None => return ExpressionFault::new(at, "expected a value, found the end"),
            Some('(') => {
                self.at += 1;
                let inner = self.parse_level(0)?;
                self.expect_closing(")")?;
                return Ok(inner);
            }
            Some('{') => {
                self.at += 1;
                ExpressionTree::Set(self.parse_list("}")?)
            }
            Some(quote @ ('"' | '\'')) => {
                let Some(end) = rest[1..].find(quote) else {
                    return ExpressionFault::new(at, format!("expected a closing {quote}, found the end"));
                };
                self.at += end + 2;
                ExpressionTree::Text(rest[1..=end].into())
            }
            Some(c) if c.is_ascii_digit() || c == '.' => {
                let end = rest.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(rest.len());
                self.at += end;
                match rest[..end].parse() {
                    Ok(number) => ExpressionTree::Number(number),
                    Err(_) => return ExpressionFault::new(at, format!("expected a number, found `{}`", &rest[..end])),
                }
            }
            Some(c) if c.is_ascii_alphabetic() => {
                let end = rest.find(|c| !is_of_word(c)).unwrap_or(rest.len());
                self.at += end;
                match &rest[..end] {
                    "true" => ExpressionTree::Truth(true),
                    "false" => ExpressionTree::Truth(false),
                    word if self.take_token("(") => ExpressionTree::Call(word.into(), self.parse_list(")")?),
                    word => ExpressionTree::Word(word.into()),
                }
            }
            Some(c) => return ExpressionFault::new(at, format!("expected a value, found `{c}`")),
        };
        Ok(ExpressionNode { at, tree })
    }

    /// Parses expressions between commas, up to a closing bracket.
    fn parse_list(&mut self, end: &str) -> Result<Vec<ExpressionNode>, ExpressionFault> {
        let mut out = Vec::new();
        if self.take_token(end) {
            return Ok(out);
        }
        loop {
            out.push(self.parse_level(0)?);
            if !self.take_token(",") {
                return self.expect_closing(end).map(|()| out);
            }
        }
    }

    fn expect_closing(&mut self, end: &str) -> Result<(), ExpressionFault> {
        if self.take_token(end) {
            return Ok(());
        }
        let found = if self.rest().is_empty() { "the end".into() } else { format!("`{}`", first_word(self.rest())) };
        ExpressionFault::new(self.at, format!("expected `{end}`, found {found}"))
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
