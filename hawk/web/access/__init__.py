"""Access to the web server: tokens, logins, certificates, hosts."""
