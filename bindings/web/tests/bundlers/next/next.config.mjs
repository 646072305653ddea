export default { serverExternalPackages: ["facebaker"] };
