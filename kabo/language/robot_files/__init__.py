"""Files of other programs that describe robots: XML with places, SRDF, and the folders of packages that they name."""
