//! What every campaign begins with, declared once.

/// Declares the tables of a kind of campaign, behind those that all kinds have: kind, title, device and conditions.
///
/// Serde cannot refuse unknown keys where a struct is flattened into another, so the fields are written into each.
macro_rules! campaign {
    ($(#[$about:meta])* pub struct $name:ident { $($fields:tt)* }) => {
        $(#[$about])*
        #[derive(Clone, Debug, PartialEq, serde::Deserialize)]
        #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
        #[serde(deny_unknown_fields)]
        pub struct $name {
            /// Kind of the campaign.
            #[serde(rename = "kind")]
            #[cfg_attr(feature = "schema", schemars(with = "String"))]
            _kind: serde::de::IgnoredAny,
            /// The file it was read from.
            #[serde(skip, default = "crate::campaign::CampaignFile::unread")]
            pub(crate) source: crate::campaign::CampaignFile,
            /// One line for the head of the report.
            title: Option<String>,
            /// The device.
            #[serde(default)]
            pub(crate) device: proofmass_documents::Device,
            /// Conditions.
            #[serde(default)]
            pub(crate) ambient: proofmass_documents::Ambient,
            $($fields)*
        }

        impl $name {
            /// One line for the head of the report, where the campaign has one.
            pub fn title(&self) -> Option<&str> {
                self.title.as_deref()
            }

            /// What a result of these inputs is filed with.
            pub(crate) fn filed(
                &self,
                date: Option<String>,
                inputs: Vec<proofmass_io::Input>,
            ) -> crate::record::Record {
                crate::record::Record {
                    title: self.title.clone(),
                    device: self.device.clone(),
                    ambient: self.ambient.clone(),
                    date,
                    inputs,
                    ..crate::record::Record::default()
                }
            }
        }
    };
}

pub(super) use campaign;
