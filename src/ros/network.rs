//! Which DDS domain and which machines the node talks to: the ROS environment variables.

use super::newcomer::Manners;
use ros2_client::{Context, CreateError};
use rustdds::DomainParticipantBuilder;
use std::net::{IpAddr, Ipv4Addr};

/// The highest domain whose ports exist.
const LAST_DOMAIN: u16 = 232;

/// Who can be discovered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DiscoveryRange {
    /// Everybody that multicast reaches.
    #[default]
    Subnet,
    /// This machine alone.
    Localhost,
    /// Nobody.
    Off,
}

/// Where the node joins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Network {
    /// DDS domain.
    pub domain: u16,
    /// Who can be discovered.
    pub range: DiscoveryRange,
}

/// An environment variable that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{name}={value}: {expected}")]
pub struct EnvironmentError {
    /// The variable.
    pub name: &'static str,
    /// Its value.
    pub value: String,
    /// What it can be.
    pub expected: &'static str,
}

impl Network {
    /// Reads ROS_DOMAIN_ID, ROS_AUTOMATIC_DISCOVERY_RANGE and the older ROS_LOCALHOST_ONLY, which where it is 1 goes before the
    /// range, as in rcl; `variable` gives the value of an environment variable.
    ///
    /// # Errors
    /// [`EnvironmentError`] names the variable and what it can be.
    pub fn from_environment(
        variable: impl Fn(&str) -> Option<String>,
    ) -> Result<Self, EnvironmentError> {
        let value = |name| variable(name).filter(|value| !value.is_empty());
        let domain = match value("ROS_DOMAIN_ID") {
            None => 0,
            Some(text) => match text.trim().parse() {
                Ok(domain) if domain <= LAST_DOMAIN => domain,
                _ => {
                    return Err(EnvironmentError {
                        name: "ROS_DOMAIN_ID",
                        value: text,
                        expected: "expected a number from 0 to 232",
                    });
                }
            },
        };
        let range = match value("ROS_AUTOMATIC_DISCOVERY_RANGE") {
            None => DiscoveryRange::Subnet,
            Some(text) => match text.as_str() {
                "SUBNET" | "SYSTEM_DEFAULT" => DiscoveryRange::Subnet,
                "LOCALHOST" => DiscoveryRange::Localhost,
                "OFF" => DiscoveryRange::Off,
                _ => {
                    return Err(EnvironmentError {
                        name: "ROS_AUTOMATIC_DISCOVERY_RANGE",
                        value: text,
                        expected: "expected SUBNET, LOCALHOST, OFF or SYSTEM_DEFAULT",
                    });
                }
            },
        };
        let range = match value("ROS_LOCALHOST_ONLY").as_deref() {
            Some("1") => DiscoveryRange::Localhost,
            _ => range,
        };
        Ok(Self { domain, range })
    }

    /// Joins, with the manners that are due to those who are there. The socket buffers are RustDDS's own 8 MiB each way, as far as the kernel grants them.
    ///
    /// # Errors
    /// What DDS says where it cannot open its sockets.
    pub fn join(self) -> Result<(Context, Manners), CreateError> {
        let builder = DomainParticipantBuilder::new(self.domain);
        let builder = match self.range {
            DiscoveryRange::Subnet => builder,
            DiscoveryRange::Localhost => builder.with_only_networks([Ipv4Addr::LOCALHOST]),
            DiscoveryRange::Off => builder
                .with_only_networks(Vec::<IpAddr>::new())
                .same_host_loopback(false),
        };
        let participant = builder.build()?;
        let manners = Manners::new(&participant);
        Ok((Context::from_domain_participant(participant)?, manners))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(variables: &[(&str, &str)]) -> Result<Network, EnvironmentError> {
        Network::from_environment(|name| {
            let found = variables.iter().find(|(known, _)| *known == name);
            found.map(|(_, value)| (*value).to_owned())
        })
    }

    #[test]
    fn variables_are_read_as_rcl_reads_them() {
        let network = |domain, range| Ok(Network { domain, range });
        assert_eq!(read(&[]), network(0, DiscoveryRange::Subnet));
        assert_eq!(
            read(&[("ROS_DOMAIN_ID", "")]),
            network(0, DiscoveryRange::Subnet)
        );
        assert_eq!(
            read(&[
                ("ROS_DOMAIN_ID", "41"),
                ("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
            ]),
            network(41, DiscoveryRange::Localhost)
        );
        assert_eq!(
            read(&[("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")]),
            network(0, DiscoveryRange::Off)
        );
        assert_eq!(
            read(&[("ROS_LOCALHOST_ONLY", "1")]),
            network(0, DiscoveryRange::Localhost)
        );
        assert_eq!(
            read(&[("ROS_LOCALHOST_ONLY", "0")]),
            network(0, DiscoveryRange::Subnet)
        );
    }

    #[test]
    fn values_that_mean_nothing_are_refused() {
        for (name, value) in [
            ("ROS_DOMAIN_ID", "233"),
            ("ROS_DOMAIN_ID", "-1"),
            ("ROS_DOMAIN_ID", "lab"),
            ("ROS_AUTOMATIC_DISCOVERY_RANGE", "localhost"),
        ] {
            let error = read(&[(name, value)]).unwrap_err().to_string();
            assert!(error.contains(name) && error.contains(value), "{error}");
        }
    }
}
