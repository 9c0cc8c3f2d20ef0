//! How types of this workspace stand in results.

/// Has types serialised as a text that one of their methods gives; their schema is that of a text.
#[macro_export]
macro_rules! serialize_as_text {
    ($($kind:ident::$text:ident),+ $(,)?) => {$(
        impl serde::Serialize for $kind {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.collect_str(&self.$text())
            }
        }

        impl schemars::JsonSchema for $kind {
            fn inline_schema() -> bool {
                true
            }

            fn schema_name() -> std::borrow::Cow<'static, str> {
                String::schema_name()
            }

            fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
                String::json_schema(generator)
            }
        }
    )+};
}

/// Declares an enum whose variants have names, as files and results write them.
#[macro_export]
macro_rules! named {
    ($(#[$about:meta])* $vis:vis enum $kind:ident {
        $($(#[$of:meta])* $variant:ident = $name:literal,)+
    }) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        $vis enum $kind {
            $($(#[$of])* $variant,)+
        }

        impl $kind {
            /// All of them.
            #[allow(dead_code, reason = "not all enums with names are listed")]
            $vis const ALL: [Self; [$($name),+].len()] = [$(Self::$variant),+];

            /// Its name in files and results.
            $vis fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)+
                }
            }
        }
    };
}
