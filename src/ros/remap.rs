//! Remapping rules and the names they give.

use super::names::{NameError, NodeIdentity};
use std::str::FromStr;

/// Why a remapping rule cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RemapError {
    /// There is no `:=`.
    #[error("expected from:=to")]
    NoArrow,
    /// A side is empty.
    #[error("a name is missing beside :=")]
    Empty,
    /// A name that cannot be one.
    #[error(transparent)]
    Name(#[from] NameError),
}

/// What a rule changes.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Change {
    NodeName(String),
    Namespace(String),
    Name {
        kind: Option<NameKind>,
        from: String,
        to: String,
    },
}

/// What a name names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NameKind {
    /// A topic.
    Topic,
    /// A service.
    Service,
}

impl NameKind {
    fn word(self) -> &'static str {
        match self {
            Self::Topic => "topic",
            Self::Service => "service",
        }
    }
}

/// `[node:]from:=to`, where from may be a topic or service name, `__node`, `__name` or `__ns`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RemapRule {
    node: Option<String>,
    change: Change,
}

impl FromStr for RemapRule {
    type Err = RemapError;

    fn from_str(rule: &str) -> Result<Self, RemapError> {
        let (left, to) = rule.split_once(":=").ok_or(RemapError::NoArrow)?;
        let (node, from) = match left.split_once(':') {
            Some((node, from)) if !from.starts_with("//") => (Some(node), from),
            _ => (None, left),
        };
        if from.is_empty() || to.is_empty() || node.is_some_and(str::is_empty) {
            return Err(RemapError::Empty);
        }
        // any node name serves to find out whether a name is valid
        let anyone = NodeIdentity::new("/", node.unwrap_or("node"))?;
        let change = match from {
            "__node" | "__name" => Change::NodeName(NodeIdentity::new("/", to)?.name().to_owned()),
            "__ns" => Change::Namespace(NodeIdentity::new(to, "node")?.namespace().to_owned()),
            _ => {
                let (kind, from) = if let Some(topic) = from.strip_prefix("rostopic://") {
                    (Some(NameKind::Topic), topic)
                } else if let Some(service) = from.strip_prefix("rosservice://") {
                    (Some(NameKind::Service), service)
                } else {
                    (None, from)
                };
                let word = kind.map_or("topic or service", NameKind::word);
                anyone.expand(word, from)?;
                anyone.expand(word, to)?;
                Change::Name {
                    kind,
                    from: from.to_owned(),
                    to: to.to_owned(),
                }
            }
        };
        Ok(Self {
            node: node.map(str::to_owned),
            change,
        })
    }
}

impl RemapRule {
    /// The new name of the node that is called `node`, where this rule gives one.
    pub fn node_name(&self, node: &str) -> Option<&str> {
        match &self.change {
            Change::NodeName(name) if self.concerns(node) => Some(name),
            _ => None,
        }
    }

    /// The namespace of the node that is called `node`, where this rule gives one.
    pub fn namespace(&self, node: &str) -> Option<&str> {
        match &self.change {
            Change::Namespace(namespace) if self.concerns(node) => Some(namespace),
            _ => None,
        }
    }

    fn concerns(&self, node: &str) -> bool {
        self.node.as_deref().is_none_or(|only| only == node)
    }
}

/// Gives the names of a node's topics and services: expanded, then remapped by the first rule that fits.
#[derive(Debug, Clone)]
pub struct Names {
    node: NodeIdentity,
    rules: Vec<RemapRule>,
}

impl Names {
    /// The names of `node` under `rules`.
    pub fn new(node: NodeIdentity, rules: Vec<RemapRule>) -> Self {
        Self { node, rules }
    }

    /// The node.
    pub fn node(&self) -> &NodeIdentity {
        &self.node
    }

    /// The absolute name under which the node uses the topic it calls `name`.
    ///
    /// # Errors
    /// [`NameError`] where the name or its replacement is not valid.
    pub fn topic(&self, name: &str) -> Result<String, NameError> {
        self.resolve(NameKind::Topic, name)
    }

    /// The absolute name under which the node uses the service it calls `name`.
    ///
    /// # Errors
    /// [`NameError`] where the name or its replacement is not valid.
    pub fn service(&self, name: &str) -> Result<String, NameError> {
        self.resolve(NameKind::Service, name)
    }

    fn resolve(&self, wanted: NameKind, name: &str) -> Result<String, NameError> {
        let expanded = self.node.expand(wanted.word(), name)?;
        for rule in self.rules.iter().filter(|r| r.concerns(self.node.name())) {
            let Change::Name { kind, from, to } = &rule.change else {
                continue;
            };
            let fits = kind.is_none_or(|kind| kind == wanted)
                && self.node.expand(wanted.word(), from)? == expanded;
            if fits {
                return self.node.expand(wanted.word(), to);
            }
        }
        Ok(expanded)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(rules: &[&str]) -> Names {
        let node = NodeIdentity::new("/cams", "ringcal").unwrap();
        Names::new(node, rules.iter().map(|r| r.parse().unwrap()).collect())
    }

    #[test]
    fn names_are_expanded_before_they_are_compared() {
        for rule in ["image:=/left/image", "/cams/image:=/left/image"] {
            assert_eq!(names(&[rule]).topic("image").unwrap(), "/left/image");
        }
        for rule in [
            "~/status:=s",
            "/cams/ringcal/status:=s",
            "ringcal/status:=s",
        ] {
            assert_eq!(
                names(&[rule]).topic("~/status").unwrap(),
                "/cams/s",
                "{rule}"
            );
        }
        assert_eq!(
            names(&["image:=~/in"]).topic("image").unwrap(),
            "/cams/ringcal/in"
        );
        // /image is another topic than /cams/image
        assert_eq!(
            names(&["/image:=/x"]).topic("image").unwrap(),
            "/cams/image"
        );
    }

    #[test]
    fn the_first_rule_that_fits_wins_and_results_are_not_remapped_again() {
        let names = names(&["image:=a", "image:=b", "a:=c"]);
        assert_eq!(names.topic("image").unwrap(), "/cams/a");
    }

    #[test]
    fn rules_may_be_for_one_node_or_one_kind() {
        assert_eq!(
            names(&["ringcal:image:=a"]).topic("image").unwrap(),
            "/cams/a"
        );
        assert_eq!(
            names(&["other:image:=a"]).topic("image").unwrap(),
            "/cams/image"
        );
        let names = names(&["rosservice://~/save:=a", "rostopic://~/status:=b"]);
        assert_eq!(names.service("~/save").unwrap(), "/cams/a");
        assert_eq!(names.topic("~/save").unwrap(), "/cams/ringcal/save");
        assert_eq!(names.topic("~/status").unwrap(), "/cams/b");
    }

    #[test]
    fn rules_that_cannot_be_are_refused() {
        for rule in [
            "image",
            "image:=",
            ":=x",
            ":image:=x",
            "a b:=x",
            "a:=x//y",
            "__ns:=/a/",
            "__node:=2",
            "a*:=b",
        ] {
            assert!(rule.parse::<RemapRule>().is_err(), "{rule}");
        }
    }
}
