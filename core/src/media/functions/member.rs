//! What members of a family have in common: parameters that may turn into others and back.

/// Declares a kind of member: its parameters, the same as a morph's target, and what they are at a time.
macro_rules! member {
    (
        $(#[$doc:meta])* $Name:ident, $Morph:ident, $Parameters:ident {
            $($(#[$field_doc:meta])* $field:ident: $ty:ty = $default:expr),* $(,)?
        }
    ) => {
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
        #[serde(default, deny_unknown_fields)]
        pub struct $Name {
            $($(#[$field_doc])* pub $field: $ty,)*
            /// What it turns into and back while time goes on.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub morph: Option<$Morph>,
        }

        /// Turns into other parameters and back, in a straight line.
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
        #[serde(default, deny_unknown_fields)]
        pub struct $Morph {
            /// What it is in the middle of a period.
            pub to: $Parameters,
            /// After this time it is again what it was [s].
            #[schemars(range(min = limits::PERIOD.min, max = limits::PERIOD.max))]
            pub period_s: f64,
        }

        /// The parameters of such a member at one time.
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
        #[serde(default, deny_unknown_fields)]
        pub struct $Parameters {
            $($(#[$field_doc])* pub $field: $ty,)*
        }

        impl Default for $Name {
            fn default() -> Self {
                Self { $($field: $default,)* morph: None }
            }
        }

        impl Default for $Morph {
            fn default() -> Self {
                Self { to: $Parameters::default(), period_s: 10.0 }
            }
        }

        impl Default for $Parameters {
            fn default() -> Self {
                Self { $($field: $default),* }
            }
        }

        impl $Name {
            /// Its parameters as long as it has not begun to turn.
            pub fn own(&self) -> $Parameters {
                $Parameters { $($field: self.$field.clone()),* }
            }

            /// Its parameters at a time [s].
            pub fn at(&self, time_s: f64) -> $Parameters {
                let own = self.own();
                let Some(morph) = &self.morph else { return own };
                let share = $crate::media::functions::member::there_and_back(time_s / morph.period_s);
                $Parameters { $($field: $crate::media::toward::Toward::toward(&own.$field, &morph.to.$field, share)),* }
            }
        }
    };
}
pub(super) use member;

/// From 0 to 1 and back, once while its argument grows by 1.
pub fn there_and_back(turns: f64) -> f64 {
    1.0 - (1.0 - 2.0 * (turns - turns.floor())).abs()
}
