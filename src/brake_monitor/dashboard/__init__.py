"""The web page of what is published: a Zenoh subscriber on one side, browsers on the other. It only reads."""
