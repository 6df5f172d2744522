//! Names of nodes, topics and services: what is valid, and how relative and private names become absolute ones.

/// Why a name cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{name:?} is not a valid {kind} name: {reason}")]
pub struct NameError {
    /// What the name was to be: node, namespace, topic or service.
    pub kind: &'static str,
    /// The name as given.
    pub name: String,
    /// What is wrong with it.
    pub reason: &'static str,
}

/// A node: its namespace and its name in it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NodeIdentity {
    namespace: String,
    name: String,
}

impl NodeIdentity {
    /// A node `name` in `namespace`; the namespace may lack its leading slash, and `""` is `/`, as in rcl.
    ///
    /// # Errors
    /// [`NameError`] where either is not valid.
    pub fn new(namespace: &str, name: &str) -> Result<Self, NameError> {
        check_token(name).map_err(|reason| refusal("node", name, reason))?;
        let namespace = if namespace.starts_with('/') {
            namespace.to_owned()
        } else {
            format!("/{namespace}")
        };
        if namespace != "/" {
            check_absolute(&namespace)
                .map_err(|reason| refusal("namespace", &namespace, reason))?;
        }
        Ok(Self {
            namespace,
            name: name.to_owned(),
        })
    }

    /// The namespace, starting with a slash; `/` is the root.
    pub fn namespace(&self) -> &str {
        &self.namespace
    }

    /// The name within the namespace.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Namespace and name, e.g. `/cameras/ringcal`.
    pub fn fully_qualified(&self) -> String {
        self.relative(&self.name)
    }

    /// The absolute name that `name` means to this node: `/x` is itself, `~` and `~/x` lie under the node, anything else under
    /// its namespace. `{node}`, `{ns}` and `{namespace}` are replaced.
    ///
    /// # Errors
    /// [`NameError`] where the result is not a valid `kind` ("topic" or "service") name.
    pub fn expand(&self, kind: &'static str, name: &str) -> Result<String, NameError> {
        let filled = name
            .replace("{node}", &self.name)
            .replace("{ns}", &self.namespace)
            .replace("{namespace}", &self.namespace);
        let absolute = if filled == "~" {
            self.fully_qualified()
        } else if let Some(rest) = filled.strip_prefix("~/") {
            format!("{}/{rest}", self.fully_qualified())
        } else if filled.starts_with('/') {
            filled
        } else {
            self.relative(&filled)
        };
        check_absolute(&absolute).map_err(|reason| refusal(kind, name, reason))?;
        Ok(absolute)
    }

    fn relative(&self, name: &str) -> String {
        if self.namespace == "/" {
            format!("/{name}")
        } else {
            format!("{}/{name}", self.namespace)
        }
    }
}

fn refusal(kind: &'static str, name: &str, reason: &'static str) -> NameError {
    NameError {
        kind,
        name: name.to_owned(),
        reason,
    }
}

/// One part of a name: letters, digits and underscores, not starting with a digit.
fn check_token(token: &str) -> Result<(), &'static str> {
    match token.chars().next() {
        None => return Err("a part of it is empty"),
        Some(first) if first.is_ascii_digit() => return Err("a part of it starts with a digit"),
        Some(_) => {}
    }
    let valid = |c: char| c.is_ascii_alphanumeric() || c == '_';
    if !token.chars().all(valid) {
        return Err("only letters, digits, underscores and slashes may be used");
    }
    Ok(())
}

/// A whole name that starts with a slash.
fn check_absolute(name: &str) -> Result<(), &'static str> {
    let rest = name.strip_prefix('/').ok_or("it must start with a slash")?;
    rest.split('/').try_for_each(check_token)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_expand_as_in_rcl() {
        let node = NodeIdentity::new("/cameras", "ringcal").unwrap();
        for (name, expected) in [
            ("image", "/cameras/image"),
            ("a/b", "/cameras/a/b"),
            ("/image", "/image"),
            ("~/status", "/cameras/ringcal/status"),
            ("~", "/cameras/ringcal"),
            ("{node}/x", "/cameras/ringcal/x"),
            ("{ns}/x", "/cameras/x"),
        ] {
            assert_eq!(node.expand("topic", name).unwrap(), expected, "{name}");
        }
        let root = NodeIdentity::new("", "ringcal").unwrap();
        assert_eq!(root.namespace(), "/");
        assert_eq!(root.expand("topic", "image").unwrap(), "/image");
        assert_eq!(root.expand("topic", "~/status").unwrap(), "/ringcal/status");
    }

    #[test]
    fn invalid_names_are_refused_with_the_reason() {
        let node = NodeIdentity::new("/", "ringcal").unwrap();
        for name in [
            "", "/", "a/", "/a//b", "2a", "a/2b", "~x", "a b", "a-b", "~/", "{other}",
        ] {
            assert!(node.expand("topic", name).is_err(), "{name:?}");
        }
        for (namespace, name) in [
            ("/", ""),
            ("/", "a/b"),
            ("/a/", "b"),
            ("//", "b"),
            ("/", "2"),
        ] {
            assert!(
                NodeIdentity::new(namespace, name).is_err(),
                "{namespace} {name}"
            );
        }
        let error = node.expand("service", "2a").unwrap_err().to_string();
        assert!(
            error.contains("service") && error.contains("2a") && error.contains("digit"),
            "{error}"
        );
    }

    #[test]
    fn a_namespace_gets_its_slash() {
        let node = NodeIdentity::new("robot/left", "ringcal").unwrap();
        assert_eq!(node.fully_qualified(), "/robot/left/ringcal");
    }
}
