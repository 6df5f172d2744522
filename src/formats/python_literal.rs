//! The literals of Python that mrcal's files are made of: dictionaries, lists, tuples, strings and numbers.

/// A value.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Literal {
    /// None, True or False.
    Word(&'static str),
    /// An integer or a float.
    Number(f64),
    /// A string, or bytes.
    Text(String),
    /// A list or a tuple.
    Sequence(Vec<Literal>),
    /// A dictionary whose keys are strings, in their order.
    Map(Vec<(String, Literal)>),
}

/// Where a text stops being a literal, and what was expected there.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("line {line}: {expected} expected")]
pub(super) struct NoLiteral {
    line: usize,
    expected: &'static str,
}

/// Deeper files are made to exhaust the stack.
const DEEPEST: usize = 16;

/// The literal that a text is, with comments and white space around its parts.
pub(super) fn parse(text: &str) -> Result<Literal, NoLiteral> {
    let mut reader = Reader { text, at: 0 };
    let value = reader.value(0)?;
    match reader.peek() {
        None => Ok(value),
        Some(_) => reader.refuse("the end of the file"),
    }
}

struct Reader<'a> {
    text: &'a str,
    /// Bytes that are read.
    at: usize,
}

impl<'a> Reader<'a> {
    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    fn refuse<T>(&self, expected: &'static str) -> Result<T, NoLiteral> {
        let line = 1 + self.text[..self.at].matches('\n').count();
        Err(NoLiteral { line, expected })
    }

    /// The next character behind white space and comments.
    fn peek(&mut self) -> Option<char> {
        loop {
            let rest = self.rest();
            let trimmed = rest.trim_start();
            self.at += rest.len() - trimmed.len();
            if !trimmed.starts_with('#') {
                return trimmed.chars().next();
            }
            self.at += trimmed.find('\n').unwrap_or(trimmed.len());
        }
    }

    /// Reads a character if it is the next one.
    fn take(&mut self, wanted: char) -> bool {
        let there = self.peek() == Some(wanted);
        if there {
            self.at += wanted.len_utf8();
        }
        there
    }

    fn value(&mut self, depth: usize) -> Result<Literal, NoLiteral> {
        if depth > DEEPEST {
            return self.refuse("less depth");
        }
        if self.take('{') {
            return self.map(depth);
        }
        if self.take('[') {
            return self.sequence(']', depth);
        }
        if self.take('(') {
            return self.sequence(')', depth);
        }
        match self.peek() {
            Some('\'' | '"') => self.string().map(Literal::Text),
            Some(c) if c.is_ascii_alphabetic() => self.word(),
            Some(_) => self.number(),
            None => self.refuse("a value"),
        }
    }

    fn sequence(&mut self, end: char, depth: usize) -> Result<Literal, NoLiteral> {
        let mut values = Vec::new();
        while !self.take(end) {
            values.push(self.value(depth + 1)?);
            if !self.take(',') && self.peek() != Some(end) {
                return self.refuse("a comma or the end of the list");
            }
        }
        Ok(Literal::Sequence(values))
    }

    fn map(&mut self, depth: usize) -> Result<Literal, NoLiteral> {
        let mut entries = Vec::new();
        while !self.take('}') {
            if !matches!(self.peek(), Some('\'' | '"')) {
                return self.refuse("a key in quotes");
            }
            let key = self.string()?;
            if !self.take(':') {
                return self.refuse("a colon");
            }
            entries.push((key, self.value(depth + 1)?));
            if !self.take(',') && self.peek() != Some('}') {
                return self.refuse("a comma or the end of the dictionary");
            }
        }
        Ok(Literal::Map(entries))
    }

    /// A string from its opening quote on, which is the next character.
    fn string(&mut self) -> Result<String, NoLiteral> {
        let mut characters = self.rest().char_indices();
        let Some((_, quote)) = characters.next() else {
            return self.refuse("a string");
        };
        let mut text = String::new();
        while let Some((at, c)) = characters.next() {
            match c {
                '\n' => break,
                '\\' => match characters.next() {
                    Some((_, c @ ('\\' | '\'' | '"'))) => text.push(c),
                    _ => return self.refuse("no escape but of quotes and backslashes"),
                },
                _ if c == quote => {
                    self.at += at + 1;
                    return Ok(text);
                }
                _ => text.push(c),
            }
        }
        self.refuse("the end of the string")
    }

    /// None, True, False, or the letter before bytes.
    fn word(&mut self) -> Result<Literal, NoLiteral> {
        for word in ["None", "True", "False"] {
            if self.rest().starts_with(word) {
                self.at += word.len();
                return Ok(Literal::Word(word));
            }
        }
        if self.rest().starts_with(['b', 'r', 'u']) && self.rest()[1..].starts_with(['\'', '"']) {
            self.at += 1;
            return self.string().map(Literal::Text);
        }
        self.refuse("a number, a string, a list or a dictionary")
    }

    fn number(&mut self) -> Result<Literal, NoLiteral> {
        let rest = self.rest();
        let part = |c: char| c.is_ascii_digit() || "+-.eE".contains(c);
        let end = rest.find(|c| !part(c)).unwrap_or(rest.len());
        match rest[..end].parse() {
            Ok(value) => {
                self.at += end;
                Ok(Literal::Number(value))
            }
            Err(_) => self.refuse("a number"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn everything_that_mrcal_writes_is_read() {
        let text = "# note\n{ 'a': [ 1, -2.5e-3,], # more\n \"b\\\"\": (None, True, b'x#\\''),\n'c': {} }\n";
        let wanted = Literal::Map(vec![
            (
                "a".into(),
                Literal::Sequence(vec![Literal::Number(1.0), Literal::Number(-0.0025)]),
            ),
            (
                "b\"".into(),
                Literal::Sequence(vec![
                    Literal::Word("None"),
                    Literal::Word("True"),
                    Literal::Text("x#'".into()),
                ]),
            ),
            ("c".into(), Literal::Map(vec![])),
        ]);
        assert_eq!(parse(text).unwrap(), wanted);
    }

    #[test]
    fn refusals_say_where_and_what() {
        let refused = |text: &str| parse(text).unwrap_err().to_string();
        assert_eq!(refused("{'a': 1,\n 'b' 2}"), "line 2: a colon expected");
        assert_eq!(
            refused("[1\n2]"),
            "line 2: a comma or the end of the list expected"
        );
        assert_eq!(refused("{a: 1}"), "line 1: a key in quotes expected");
        assert_eq!(refused("'abc\n'"), "line 1: the end of the string expected");
        assert_eq!(refused("[1] 2"), "line 1: the end of the file expected");
        assert!(refused("open('f')").contains("a number, a string"));
        assert!(refused("").contains("a value"));
        assert!(refused("1-2").contains("a number"));
        assert!(refused(&"[".repeat(100_000)).contains("less depth"));
    }

    proptest! {
        #[test]
        fn no_text_brings_it_down(text in "[\\[\\](){}'\"#,:0-9eE.+\\-bNone \\\\\n\u{e9}]{0,40}") {
            let _ = parse(&text);
        }
    }
}
