"""Validates digital certificates against the schema of DCC 3.3.0 under FOLDER/dcc/schema; nothing is fetched.

Usage: dcc_schema.py FOLDER CERTIFICATE... Ends with 77 where lxml is not there.
"""

import os
import sys

try:
    from lxml import etree
except ImportError:
    sys.exit(77)

base = os.path.join(sys.argv[1], "dcc", "schema")


class Local(etree.Resolver):
    """The schema names its parts by their addresses; all of them stand beside it."""

    def resolve(self, url, _, context):
        for word, place in (
            ("SI_Format", "dcc/dsi/v2.2.1.xsd"),
            ("xmldsig", "xmldsig/xmldsig-core-schema.xsd"),
            ("qudt", "dcc/qudt/v2.2.1.xsd"),
        ):
            if word.lower() in url.lower() and not os.path.exists(url):
                return self.resolve_filename(os.path.join(base, place), context)


parser = etree.XMLParser(no_network=True)
parser.resolvers.add(Local())
schema = etree.XMLSchema(etree.parse(os.path.join(base, "dcc/v3.3.0/dcc.xsd"), parser))
wrong = 0
for certificate in sys.argv[2:]:
    if not schema.validate(etree.parse(certificate)):
        wrong += 1
        for error in schema.error_log:
            print(f"{certificate}:{error.line}: {error.message}")
sys.exit(1 if wrong else 0)
