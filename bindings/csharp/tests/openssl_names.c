/* .NET Core 3.1 asks OpenSSL 1.1 for three functions that OpenSSL 3 calls otherwise or lacks. A library that has them, and all
 * of OpenSSL 3 behind it, is taken in its place where CLR_OPENSSL_VERSION_OVERRIDE names it. For tests alone. */
int EVP_MD_get_size(const void* digest);
void* SSL_get1_peer_certificate(const void* connection);

int EVP_MD_size(const void* digest)
{
    return EVP_MD_get_size(digest);
}

void* SSL_get_peer_certificate(const void* connection)
{
    return SSL_get1_peer_certificate(connection);
}

void ERR_put_error(int library, int function, int reason, const char* file, int line)
{
    (void)library, (void)function, (void)reason, (void)file, (void)line;
}
